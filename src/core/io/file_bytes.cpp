// SPDX-License-Identifier: Apache-2.0
#include "core/io/file_bytes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "core/error.h"

namespace brume {
namespace {

/// The other files of the directory of `path`, for a spelling suggestion.
std::vector<std::string> namesBeside(const std::filesystem::path& path) {
  constexpr int kMaxNames = 4096;  // a suggestion must not cost a walk over a huge directory
  std::vector<std::string> names;
  std::error_code error;
  const std::filesystem::path directory = path.has_parent_path() ? path.parent_path() : ".";
  for (std::filesystem::directory_iterator it(directory, error), end;
       !error && it != end && names.size() < kMaxNames; it.increment(error))
    names.push_back(it->path().filename().string());
  return names;
}

std::string missingFileText(const std::string& path, int error) {
  if (error != ENOENT) return fmt::format("cannot open '{}': {}", path, std::strerror(error));
  const std::filesystem::path p(path);
  std::error_code ignored;
  if (p.has_parent_path() && !std::filesystem::is_directory(p.parent_path(), ignored))
    return fmt::format("cannot open '{}': the directory '{}' does not exist", path,
                       p.parent_path().string());
  return fmt::format("cannot open '{}': no such file{}", path,
                     nearestSpelling(p.filename().string(), namesBeside(p)));
}

struct Descriptor {
  int value;
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
};

}  // namespace

std::string formatBytes(double bytes) {
  const char* const units[] = {"bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  int unit = 0;
  for (; bytes >= 1024 && unit < 6; ++unit) bytes /= 1024;
  return unit == 0 ? fmt::format("{:.0f} bytes", bytes)
                   : fmt::format("{:.1f} {}", bytes, units[unit]);
}

Bytes readFileBytes(const std::string& path, std::uint64_t limit) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.value < 0) throw SceneError(missingFileText(path, errno));
  struct stat info {};
  if (::fstat(file.value, &info) != 0)
    throw SceneError(fmt::format("cannot read '{}': {}", path, std::strerror(errno)));
  if (S_ISDIR(info.st_mode)) throw SceneError(fmt::format("'{}' is a directory", path));
  if (!S_ISREG(info.st_mode) && !S_ISFIFO(info.st_mode))
    throw SceneError(fmt::format("'{}' is neither a file nor a pipe", path));
  const auto tooLarge = [&](double size) {
    return SceneError(fmt::format("'{}' is too large: {}; the limit is {}", path, formatBytes(size),
                                  formatBytes(static_cast<double>(limit))));
  };
  if (S_ISREG(info.st_mode) && static_cast<std::uint64_t>(info.st_size) > limit)
    throw tooLarge(static_cast<double>(info.st_size));

  // A regular file arrives in one read; a pipe of unknown size grows by pieces.
  constexpr std::size_t kPiece = 1 << 16;
  Bytes bytes(S_ISREG(info.st_mode) ? static_cast<std::size_t>(info.st_size) + 1 : kPiece);
  std::size_t size = 0;
  for (;;) {
    if (size == bytes.size()) bytes.resize(2 * size);
    const ssize_t got = ::read(file.value, bytes.data() + size, bytes.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw SceneError(fmt::format("cannot read '{}': {}", path, std::strerror(errno)));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
    if (size > limit) throw tooLarge(static_cast<double>(size));
  }
  bytes.resize(size);
  return bytes;
}

std::optional<FilePieces> FilePieces::open(const std::string& path) {
  // A pipe is not even opened: its writer would think that it has a reader.
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0 || !S_ISREG(info.st_mode)) return std::nullopt;
  FilePieces file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK), 0);
  if (file.descriptor_ < 0 || ::fstat(file.descriptor_, &info) != 0 || !S_ISREG(info.st_mode))
    return std::nullopt;
  file.size_ = static_cast<std::uint64_t>(info.st_size);
  return file;
}

FilePieces::FilePieces(FilePieces&& o) noexcept
    : descriptor_(std::exchange(o.descriptor_, -1)), size_(o.size_) {}

FilePieces::~FilePieces() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Bytes FilePieces::read(std::uint64_t offset, std::size_t count) const {
  if (offset >= size_) return {};
  Bytes bytes(static_cast<std::size_t>(std::min<std::uint64_t>(count, size_ - offset)));
  std::size_t got = 0;
  while (got < bytes.size()) {
    const ssize_t n = ::pread(descriptor_, bytes.data() + got, bytes.size() - got,
                              static_cast<off_t>(offset + got));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    got += static_cast<std::size_t>(n);
  }
  bytes.resize(got);
  return bytes;
}

AtomicFile::AtomicFile(const std::string& path) : path_(path), target_(path) {
  std::error_code error;
  if (std::filesystem::is_symlink(path, error)) {
    const auto resolved = std::filesystem::weakly_canonical(path, error);
    if (!error) target_ = resolved.string();
  }
  const bool exists = std::filesystem::exists(target_, error);
  // A directory, and a device too: renaming would replace it.
  if (exists && !std::filesystem::is_regular_file(target_, error))
    throw SceneError(fmt::format("cannot write '{}': it exists and is not a regular file", path));
  if (exists && ::access(target_.c_str(), W_OK) != 0) fail("write", errno);

  static std::atomic<unsigned> counter{0};
  for (int attempt = 0; attempt < 100 && descriptor_ < 0; ++attempt) {
    temporary_ = fmt::format("{}.{}-{}.part", target_, ::getpid(), counter++);
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0 && errno != EEXIST) break;
  }
  if (descriptor_ < 0) {
    const int code = errno;
    temporary_.clear();
    fail("write", code);
  }
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::fail(const std::string& what, int error) const {
  throw SceneError(fmt::format("cannot {} '{}': {}", what, path_, std::strerror(error)));
}

void AtomicFile::write(const void* data, std::size_t size) {
  const char* bytes = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = ::write(descriptor_, bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("write", errno);
    bytes += written;
    size -= static_cast<std::size_t>(written);
    position_ += static_cast<std::uint64_t>(written);
  }
}

void AtomicFile::seek(std::uint64_t position) {
  if (::lseek(descriptor_, static_cast<off_t>(position), SEEK_SET) < 0) fail("write", errno);
  position_ = position;
}

void AtomicFile::commit() {
  // Some file systems cannot synchronise (EINVAL); a full disk or a lost server is an error here.
  if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != ENOTSUP) fail("write", errno);
  const int closed = ::close(descriptor_);
  descriptor_ = -1;
  if (closed != 0) fail("write", errno);
  if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail("write", errno);
  temporary_.clear();
}

}  // namespace brume
