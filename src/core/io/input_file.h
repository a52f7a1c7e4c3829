// SPDX-License-Identifier: Apache-2.0
// The bytes of an input file. Large files are mapped, so that text which has been read needs no
// memory.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/error.h"

namespace brume {

/// The content of a file for as long as the object lives. Movable; the view stays valid.
class InputFile {
 public:
  enum class Accept {
    RegularFiles,  ///< anything else (directory, pipe, device) is an error
    Streams        ///< pipes too; they are read to their end, at most kMaxStreamBytes
  };
  static constexpr std::size_t kMaxStreamBytes = std::size_t{1} << 29;

  /// Throws SceneError at `blame` with the reason when the file cannot be read.
  static InputFile open(const std::string& path, Accept accept, const SourceLocation& blame);
  static InputFile standardInput();
  /// A view of memory that outlives the object.
  static InputFile borrow(std::string_view text);

  InputFile(InputFile&& o) noexcept { *this = std::move(o); }
  InputFile& operator=(InputFile&& o) noexcept;
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile();

  std::string_view view() const { return view_; }
  /// The pages that lie wholly in [begin, end) need not stay in memory; they come back when they
  /// are read again.
  void release(std::size_t begin, std::size_t end) const;

  /// Two paths lead to the same file when these are equal; none for streams and memory.
  using Identity = std::pair<std::uint64_t, std::uint64_t>;
  const std::optional<Identity>& identity() const { return identity_; }

 private:
  InputFile() = default;
  static InputFile readStream(int descriptor, const std::string& name, const SourceLocation& blame);

  std::string_view view_;
  struct Free {
    void operator()(char* p) const { std::free(p); }
  };
  std::unique_ptr<char, Free> owned_;  // small files and streams; grows in place where it can
  void* mapped_ = nullptr;             // large files
  std::optional<Identity> identity_;
};

}  // namespace brume
