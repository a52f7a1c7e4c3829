// SPDX-License-Identifier: Apache-2.0
#include "core/io/source_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <mutex>
#include <set>

namespace brume {

const std::string* internFileName(std::string_view name) {
  static std::mutex mutex;
  static std::set<std::string, std::less<>> names;  // nodes do not move
  std::lock_guard lock(mutex);
  auto it = names.find(name);
  if (it == names.end()) it = names.emplace(name).first;
  return &*it;
}

SourceLocation SourceFile::locate(const char* position) {
  const std::string_view all = text();
  const std::size_t offset = static_cast<std::size_t>(position - all.data());
  if (offset < lineStart_) {
    counted_ = lineStart_ = 0;
    line_ = 1;
  }
  // Count the lines since the last question; the column starts behind the last newline.
  if (offset > counted_) {
    const std::string_view passed = all.substr(counted_, offset - counted_);
    const auto lines = std::count(passed.begin(), passed.end(), '\n');
    if (lines > 0) {
      line_ += static_cast<std::uint32_t>(lines);
      lineStart_ = counted_ + passed.rfind('\n') + 1;
    }
    counted_ = offset;
  }
  return {name_, line_, static_cast<std::uint32_t>(offset - lineStart_ + 1)};
}

void SourceFile::release(const char* position) {
  locate(position);
  bytes_.release(released_, counted_);
  released_ = counted_;
}

void SourceFile::forget(const char* begin, const char* end) const {
  bytes_.release(static_cast<std::size_t>(begin - text().data()),
                 static_cast<std::size_t>(end - text().data()));
}

const char* skipComment(const char* p, const char* end) {
  const void* newline = std::memchr(p, '\n', static_cast<std::size_t>(end - p));
  return newline ? static_cast<const char*>(newline) + 1 : end;
}

std::string quote(std::string_view text, char mark) {
  constexpr std::size_t kLongest = 40;
  std::string shown(1, mark);
  for (char c : text.substr(0, kLongest)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f)
      shown += fmt::format("\\x{:02x}", byte);
    else
      shown += c;
  }
  return shown + (text.size() > kLongest ? "..." : "") + mark;
}

std::string quoteRun(const char* p, const char* end) {
  const char* last = p;
  while (last < end && !endsNumber(*last)) ++last;
  return quote({p, static_cast<std::size_t>(last - p)});
}

}  // namespace brume
