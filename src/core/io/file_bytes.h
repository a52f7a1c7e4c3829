// SPDX-License-Identifier: Apache-2.0
// Whole files in and out: reading with a size limit, writing that appears whole or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace brume {

using Bytes = std::vector<unsigned char>;
using ByteSpan = std::span<const unsigned char>;

/// The bytes of a regular file (or a pipe) of at most `limit` bytes. Throws SceneError with the
/// reason; for a missing file it names the nearest spelling in the same directory.
Bytes readFileBytes(const std::string& path, std::uint64_t limit);

/// A regular file that is read by pieces.
class FilePieces {
 public:
  /// None when there is no such file, it cannot be read or is not a regular one.
  static std::optional<FilePieces> open(const std::string& path);
  FilePieces(FilePieces&& o) noexcept;
  FilePieces& operator=(FilePieces&&) = delete;
  ~FilePieces();

  std::uint64_t size() const { return size_; }
  /// `count` bytes from `offset` on; fewer where the file ends, or cannot be read.
  Bytes read(std::uint64_t offset, std::size_t count) const;

 private:
  FilePieces(int descriptor, std::uint64_t size) : descriptor_(descriptor), size_(size) {}
  int descriptor_;
  std::uint64_t size_;
};

/// A file that is written beside its final place and renamed into it by commit(); without commit()
/// nothing remains. A symbolic link is followed, so that its target is replaced.
class AtomicFile {
 public:
  /// Opens the temporary file; throws SceneError when the directory cannot be written.
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// At the current position; throws SceneError (disk full, quota, ...).
  void write(const void* data, std::size_t size);
  std::uint64_t position() const { return position_; }
  void seek(std::uint64_t position);
  /// Flushes to the disk and renames.
  void commit();

 private:
  [[noreturn]] void fail(const std::string& what, int error) const;

  std::string path_, target_, temporary_;
  int descriptor_ = -1;
  std::uint64_t position_ = 0;
};

/// "1.5 GiB", for messages.
std::string formatBytes(double bytes);

}  // namespace brume
