// SPDX-License-Identifier: Apache-2.0
#include "core/io/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>

namespace brume {

namespace {

/// Below this a file is read: cheaper than a mapping, and safe when the file shrinks meanwhile.
constexpr std::size_t kMappedFromBytes = std::size_t{1} << 22;

/// Closes a descriptor at the end of its scope.
struct Descriptor {
  int fd = -1;
  explicit Descriptor(int d) : fd(d) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

[[noreturn]] void failToRead(const std::string& path, const SourceLocation& blame,
                             std::string_view reason) {
  throw SceneError(blame, fmt::format("cannot read '{}': {}", path, reason));
}

}  // namespace

InputFile InputFile::open(const std::string& path, Accept accept, const SourceLocation& blame) {
  if (path.find('\0') != std::string::npos)
    throw SceneError(blame, "a file name must not hold a zero byte");
  // A pipe without a writer must not block where no pipe is wanted.
  const int flags = O_RDONLY | O_CLOEXEC | (accept == Accept::Streams ? 0 : O_NONBLOCK);
  const Descriptor file(::open(path.c_str(), flags));
  struct stat status = {};
  if (file.fd < 0 || ::fstat(file.fd, &status) != 0) failToRead(path, blame, std::strerror(errno));
  if (S_ISDIR(status.st_mode)) failToRead(path, blame, "it is a directory");
  if (!S_ISREG(status.st_mode)) {
    if (accept == Accept::RegularFiles || !S_ISFIFO(status.st_mode))
      failToRead(path, blame, "it is no regular file");
    return readStream(file.fd, path, blame);
  }

  InputFile result;
  result.identity_ = Identity{static_cast<std::uint64_t>(status.st_dev),
                              static_cast<std::uint64_t>(status.st_ino)};
  const std::size_t size = static_cast<std::size_t>(status.st_size);
  if (size < kMappedFromBytes) {
    InputFile content = readStream(file.fd, path, blame);
    content.identity_ = result.identity_;
    return content;
  }
  void* mapped = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.fd, 0);
  if (mapped == MAP_FAILED) failToRead(path, blame, std::strerror(errno));
  ::madvise(mapped, size, MADV_SEQUENTIAL);
  result.mapped_ = mapped;
  result.view_ = {static_cast<const char*>(mapped), size};
  return result;
}

InputFile InputFile::standardInput() {
  return readStream(STDIN_FILENO, "standard input", SourceLocation{});
}

InputFile InputFile::borrow(std::string_view text) {
  InputFile result;
  result.view_ = text;
  return result;
}

InputFile InputFile::readStream(int descriptor, const std::string& name,
                                const SourceLocation& blame) {
  InputFile result;
  std::size_t filled = 0, capacity = 0;
  const auto resize = [&](std::size_t bytes) {
    char* memory = static_cast<char*>(std::realloc(result.owned_.get(), bytes));
    if (!memory) throw std::bad_alloc();
    static_cast<void>(result.owned_.release());  // realloc has freed or kept it
    result.owned_.reset(memory);
    capacity = bytes;
  };
  for (;;) {
    constexpr std::size_t kChunk = std::size_t{1} << 16;
    if (filled + kChunk > capacity) resize(filled + filled / 2 + kChunk);
    const ssize_t n = ::read(descriptor, result.owned_.get() + filled, kChunk);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) failToRead(name, blame, std::strerror(errno));
    if (n == 0) break;
    filled += static_cast<std::size_t>(n);
    if (filled > kMaxStreamBytes)
      failToRead(name, blame,
                 fmt::format("a stream may hold at most {} MiB; give the file by its name",
                             kMaxStreamBytes >> 20));
  }
  resize(std::max<std::size_t>(filled, 1));
  result.view_ = {result.owned_.get(), filled};
  return result;
}

InputFile& InputFile::operator=(InputFile&& o) noexcept {
  if (this == &o) return *this;
  if (mapped_) ::munmap(mapped_, view_.size());
  owned_ = std::move(o.owned_);
  view_ = o.view_;
  mapped_ = std::exchange(o.mapped_, nullptr);
  identity_ = o.identity_;
  o.view_ = {};
  return *this;
}

InputFile::~InputFile() {
  if (mapped_) ::munmap(mapped_, view_.size());
}

void InputFile::release(std::size_t begin, std::size_t end) const {
  if (!mapped_) return;
  const std::size_t page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::size_t first = (begin + page - 1) / page * page, last = end / page * page;
  if (first < last) ::madvise(static_cast<char*>(mapped_) + first, last - first, MADV_DONTNEED);
}

}  // namespace brume
