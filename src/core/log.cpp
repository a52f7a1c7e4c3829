// SPDX-License-Identifier: Apache-2.0
#include "core/log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

namespace brume {

namespace {

/// A fault that an exporter repeats for each shape fills no disk, and each warning searches its
/// line in the file.
constexpr int kShownWarnings = 100;

/// Line `number` (from 1) of a file; none when it cannot be read again (standard input).
std::optional<std::string> readLine(const std::string& path, std::uint32_t number) {
  std::error_code unreadable;  // a pipe has been read, and opening it again would wait for ever
  if (!std::filesystem::is_regular_file(path, unreadable)) return std::nullopt;
  std::ifstream in(path, std::ios::binary);
  constexpr std::size_t kLongest = 1 << 16;
  std::string line;
  for (std::uint32_t i = 1; in; ++i) {
    if (i < number) {
      in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
      continue;
    }
    char c;
    while (line.size() < kLongest && in.get(c) && c != '\n') line += c;
    return line;
  }
  return std::nullopt;
}

}  // namespace

std::string formatDiagnostic(const SourceLocation& where, std::string_view kind,
                             const std::string& message) {
  // What a scene says may be quoted in a message, and of any length.
  constexpr std::size_t kLongestMessage = 1500;
  const std::string text =
      message.size() <= kLongestMessage ? message : message.substr(0, kLongestMessage) + "...";
  std::string result = where.isKnown() ? fmt::format("{}: {}: {}", toString(where), kind, text)
                                       : fmt::format("brume: {}: {}", kind, text);
  if (!where.isKnown() || where.line == 0 || where.column == 0) return result;
  std::optional<std::string> line = readLine(*where.file, where.line);
  if (!line) return result;

  // Show at most a terminal's width around the column; everything that would move the cursor
  // becomes a blank.
  constexpr std::size_t kShown = 96;
  for (char& c : *line)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  const std::size_t column = where.column - 1;
  if (column > line->size()) return result;
  const std::size_t first = column > kShown - 16 ? column - (kShown - 16) : 0;
  result +=
      fmt::format("\n  {}\n  {}^", line->substr(first, kShown), std::string(column - first, ' '));
  return result;
}

void Log::warning(const SourceLocation& where, const std::string& text) {
  if (options_.strict) throw SceneError(where, text);
  std::lock_guard lock(mutex_);
  ++warnings_;
  if (options_.verbosity == Verbosity::Quiet || warnings_ > kShownWarnings + 1) return;
  print(warnings_ <= kShownWarnings
            ? formatDiagnostic(where, "warning", text)
            : fmt::format("brume: warning: more than {} warnings; the others are not shown",
                          kShownWarnings));
}

void Log::verbose(const std::string& text) {
  if (options_.verbosity != Verbosity::Verbose) return;
  std::lock_guard lock(mutex_);
  print(text);
}

void Log::verboseOnce(const std::string& text) {
  if (options_.verbosity != Verbosity::Verbose) return;
  std::lock_guard lock(mutex_);
  if (std::find(once_.begin(), once_.end(), text) != once_.end()) return;
  once_.push_back(text);
  print(text);
}

int Log::warningCount() const {
  std::lock_guard lock(mutex_);
  return warnings_;
}

std::vector<std::string> Log::captured() const {
  std::lock_guard lock(mutex_);
  return lines_;
}

void Log::print(const std::string& line) {
  if (options_.capture)
    lines_.push_back(line);
  else
    std::fprintf(stderr, "%s\n", line.c_str());
}

}  // namespace brume
