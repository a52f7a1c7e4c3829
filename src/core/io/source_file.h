// SPDX-License-Identifier: Apache-2.0
// The text of one scene file, places in it, and the lexical rules that all its readers share.
#pragma once

#include <string>
#include <string_view>

#include "core/error.h"
#include "core/io/input_file.h"

namespace brume {

/// The string that SourceLocation::file points to: one per name, kept until the process ends.
/// Thread-safe.
const std::string* internFileName(std::string_view name);

/// A file that is read from front to back. Lines are counted when somebody asks for a place, each
/// byte once.
class SourceFile {
 public:
  SourceFile(InputFile bytes, const std::string* name) : bytes_(std::move(bytes)), name_(name) {}

  std::string_view text() const { return bytes_.view(); }
  const std::string* name() const { return name_; }
  const std::optional<InputFile::Identity>& identity() const { return bytes_.identity(); }
  /// Line and column of a position in text().
  SourceLocation locate(const char* position);
  /// Text before `position` will not be read soon: counts its lines and lets go of its memory.
  void release(const char* position);
  /// Lets go of the memory of [begin, end), which will be read again.
  void forget(const char* begin, const char* end) const;

 private:
  InputFile bytes_;
  const std::string* name_;
  std::size_t counted_ = 0;  // newlines are counted up to here
  std::size_t lineStart_ = 0;
  std::uint32_t line_ = 1;
  std::size_t released_ = 0;
};

constexpr bool isBlank(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }

/// Behind blanks and comments ('#' to the end of the line).
const char* skipComment(const char* p, const char* end);
inline const char* skipBlanks(const char* p, const char* end) {
  for (;;) {
    while (p < end && isBlank(*p)) ++p;
    if (p == end || *p != '#') return p;
    p = skipComment(p, end);
  }
}

/// Whether a number may stand directly before c.
constexpr bool endsNumber(char c) {
  return isBlank(c) || c == '[' || c == ']' || c == '"' || c == '#';
}

/// For messages: in quotes, at most 40 bytes, control characters as \xNN.
std::string quote(std::string_view text, char mark = '\'');
/// The same for the run of characters at p that ends at a blank, bracket, quote or comment.
std::string quoteRun(const char* p, const char* end);

}  // namespace brume
