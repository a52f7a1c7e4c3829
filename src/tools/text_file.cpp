// SPDX-License-Identifier: Apache-2.0
#include "tools/text_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "core/error.h"

namespace brume {

namespace {

/// A file beside its place, until it is whole.
class PartialFile {
 public:
  explicit PartialFile(const std::string& path)
      : path_(path), partial_(fmt::format("{}.{}.part", path, getpid())) {
    file_ = std::fopen(partial_.c_str(), "wb");
    if (!file_) fail();
    // A directory in its place shows before there is something to write.
    if (std::filesystem::is_directory(path)) {
      errno = EISDIR;
      fail();
    }
  }
  ~PartialFile() {
    if (file_) std::fclose(file_);
    std::remove(partial_.c_str());
  }
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  void finish(const std::string& text) {
    if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail();
    // Closing flushes: a full disk may show here only.
    if (std::fclose(std::exchange(file_, nullptr)) != 0) fail();
    if (std::rename(partial_.c_str(), path_.c_str()) != 0) fail();
  }

 private:
  [[noreturn]] void fail() {
    const int reason = errno;
    if (file_) std::fclose(std::exchange(file_, nullptr));
    std::remove(partial_.c_str());
    throw SceneError(fmt::format("cannot write '{}': {}", path_, std::strerror(reason)));
  }

  std::string path_, partial_;
  std::FILE* file_ = nullptr;
};

}  // namespace

void writeTextFile(const std::string& path, const std::string& text) {
  PartialFile(path).finish(text);
}

void checkTextFileWritable(const std::string& path) { PartialFile file(path); }

}  // namespace brume
