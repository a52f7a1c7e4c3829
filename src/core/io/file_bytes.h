// SPDX-License-Identifier: Apache-2.0
// Whole files in and out: reading with a size limit, writing that appears whole or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace brume {

using Bytes = std::vector<unsigned char>;
using ByteSpan = std::span<const unsigned char>;

/// The bytes of a regular file (or a pipe) of at most `limit` bytes. Throws SceneError with the
/// reason; for a missing file it names the nearest spelling in the same directory.
Bytes readFileBytes(const std::string& path, std::uint64_t limit);

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
