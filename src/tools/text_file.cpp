// SPDX-License-Identifier: Apache-2.0
#include "tools/text_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "core/error.h"

namespace brume {

void writeTextFile(const std::string& path, const std::string& text) {
  const std::string partial = fmt::format("{}.{}.part", path, getpid());
  const auto fail = [&] {
    const int reason = errno;
    std::remove(partial.c_str());
    throw SceneError(fmt::format("cannot write '{}': {}", path, std::strerror(reason)));
  };
  std::FILE* file = std::fopen(partial.c_str(), "wb");
  if (!file) fail();
  const bool isWritten = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  // Closing flushes: a full disk may show here only.
  const bool isClosed = std::fclose(file) == 0;
  if (!isWritten || !isClosed || std::rename(partial.c_str(), path.c_str()) != 0) fail();
}

}  // namespace brume
