// SPDX-License-Identifier: Apache-2.0
// The lexer: one stream of tokens over a file and everything it includes. An Include hands over to
// the other file and back at its end, even in the middle of a parameter list.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/io/number_text.h"
#include "core/io/source_file.h"

namespace brume {

struct Token {
  enum class Kind { End, Word, String, Number, Open, Close };
  Kind kind = Kind::End;
  SourceLocation where;
  std::string text;  ///< of words and strings (escapes resolved)
  double number = 0;
};
/// "the string 'x'", "the number 3", "'['", "the end of the file": what was found instead.
std::string describe(const Token& token);

class TokenStream {
 public:
  /// Relative Include names are resolved against searchDirectory.
  TokenStream(SourceFile file, std::string searchDirectory);

  const Token& peek();
  Token next();
  bool hasPeeked() const { return isPeeked_; }
  /// Makes the tokens of another file come next. Throws SceneError at `where` for a file that
  /// cannot be read, includes itself or is nested too deeply.
  void include(const std::string& name, const SourceLocation& where);

  /// Calls onNumber(double) for each number that comes next in the present file, up to the first
  /// thing that is none (or the end of the file, behind which more may come). onNumber returns what
  /// is wrong with the number, or null. The fast way for long lists: no tokens are made.
  template <class F>
  void readNumbers(F&& onNumber);
  /// How many numbers stand before the next ']' of the present file (an estimate from above when
  /// comments are mixed in); 0 when there is no bracket.
  std::size_t countNumbersAhead();

  const std::string& searchDirectory() const { return searchDirectory_; }

 private:
  struct Frame {
    SourceFile file;
    const char* cursor;
    const char* end;
    const char* released;       // text before it was let go of
    SourceLocation includedAt;  // unknown for the first file
  };
  /// Text behind the cursor is let go of in steps of this size.
  static constexpr std::ptrdiff_t kReleaseBytes = std::ptrdiff_t{1} << 22;

  void push(SourceFile file, const SourceLocation& includedAt);
  bool skipToToken();
  void lex();
  void lexNumber();
  void lexWord();
  void lexString();
  char lexEscape(const char*& p);
  [[noreturn]] void fail(const char* at, const std::string& text);
  [[noreturn]] void failNumber(const char* at, const char* problem);

  std::vector<Frame> frames_;
  std::string searchDirectory_;
  Token token_;
  bool isPeeked_ = false;
  std::size_t includeCount_ = 0;
};

template <class F>
void TokenStream::readNumbers(F&& onNumber) {
  BRUME_CHECK(!isPeeked_);
  Frame& frame = frames_.back();
  const char* p = frame.cursor;
  for (;;) {
    p = skipBlanks(p, frame.end);
    if (p == frame.end || !mayStartNumber(*p)) break;
    const NumberText number = parseNumber(p, frame.end);
    if (!number.end || (number.end < frame.end && !endsNumber(*number.end)))
      failNumber(p, "is not a number");
    if (const char* problem = onNumber(number.value)) failNumber(p, problem);
    p = number.end;
    if (p - frame.released > kReleaseBytes) {
      frame.file.release(p);
      frame.released = p;
    }
  }
  frame.cursor = p;
}

/// `name` itself when absolute, else below the search directory.
std::string resolvePath(const std::string& searchDirectory, const std::string& name);

}  // namespace brume
