// SPDX-License-Identifier: Apache-2.0
#include "core/parse/token_stream.h"

#include <fmt/format.h>

#include <cstring>
#include <filesystem>

namespace brume {

namespace {

constexpr std::size_t kMaxNesting = 32;        // as PBRT-v2
constexpr std::size_t kMaxIncludes = 100'000;  // files that include each other many times over

constexpr bool startsWord(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

}  // namespace

std::string resolvePath(const std::string& searchDirectory, const std::string& name) {
  const std::filesystem::path path(name);
  return path.is_absolute() ? name : (std::filesystem::path(searchDirectory) / path).string();
}

std::string describe(const Token& token) {
  switch (token.kind) {
    case Token::Kind::End:
      return "the end of the file";
    case Token::Kind::Word:
      return quote(token.text);
    case Token::Kind::String:
      return fmt::format("the string {}", quote(token.text));
    case Token::Kind::Number:
      return fmt::format("the number {}", token.number);
    case Token::Kind::Open:
      return "'['";
    case Token::Kind::Close:
      return "']'";
  }
  return {};
}

TokenStream::TokenStream(SourceFile file, std::string searchDirectory)
    : searchDirectory_(std::move(searchDirectory)) {
  push(std::move(file), SourceLocation{});
}

void TokenStream::push(SourceFile file, const SourceLocation& includedAt) {
  frames_.push_back({std::move(file), nullptr, nullptr, nullptr, includedAt});
  Frame& frame = frames_.back();
  const std::string_view text = frame.file.text();
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  // some editors begin files with it
  frame.cursor = text.data() + (text.substr(0, 3) == kByteOrderMark ? 3 : 0);
  frame.end = text.data() + text.size();
  frame.released = text.data();
}

void TokenStream::include(const std::string& name, const SourceLocation& where) {
  BRUME_CHECK(!isPeeked_);
  if (frames_.size() > kMaxNesting)
    throw SceneError(where, fmt::format("Include is nested more than {} deep", kMaxNesting));
  if (++includeCount_ > kMaxIncludes)
    throw SceneError(where, fmt::format("there are more than {} Includes", kMaxIncludes));
  const std::string path = resolvePath(searchDirectory_, name);
  InputFile bytes = InputFile::open(path, InputFile::Accept::RegularFiles, where);
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    if (!bytes.identity() || frames_[i].file.identity() != bytes.identity()) continue;
    std::string chain;
    for (std::size_t j = i + 1; j < frames_.size(); ++j)
      chain += fmt::format("{}, then ", toString(frames_[j].includedAt));
    throw SceneError(where, fmt::format("{} includes itself{}", quote(*frames_[i].file.name()),
                                        chain.empty() ? "" : " (by way of " + chain + "here)"));
  }
  push(SourceFile(std::move(bytes), internFileName(path)), where);
}

const Token& TokenStream::peek() {
  if (!isPeeked_) lex();
  isPeeked_ = true;
  return token_;
}

Token TokenStream::next() {
  peek();
  isPeeked_ = false;
  return std::move(token_);
}

void TokenStream::fail(const char* at, const std::string& text) {
  throw SceneError(frames_.back().file.locate(at), text);
}

void TokenStream::failNumber(const char* at, const char* problem) {
  fail(at, fmt::format("{} {}", quoteRun(at, frames_.back().end), problem));
}

/// Moves to the next token, back into the including file where one ends. False at the end of all.
bool TokenStream::skipToToken() {
  for (;;) {
    Frame& frame = frames_.back();
    frame.cursor = skipBlanks(frame.cursor, frame.end);
    if (frame.cursor != frame.end) return true;
    if (frames_.size() == 1) return false;
    frames_.pop_back();
  }
}

void TokenStream::lex() {
  const bool isEnd = !skipToToken();
  Frame& frame = frames_.back();
  token_.text.clear();
  token_.where = frame.file.locate(frame.cursor);
  if (isEnd) {
    token_.kind = Token::Kind::End;
    return;
  }
  const char c = *frame.cursor;
  if (c == '[' || c == ']') {
    token_.kind = c == '[' ? Token::Kind::Open : Token::Kind::Close;
    ++frame.cursor;
  } else if (c == '"') {
    lexString();
  } else if (mayStartNumber(c)) {
    lexNumber();
  } else if (startsWord(c)) {
    lexWord();
  } else {
    fail(frame.cursor, fmt::format("unexpected character {}", quote({frame.cursor, 1})));
  }
}

void TokenStream::lexNumber() {
  Frame& frame = frames_.back();
  const NumberText number = parseNumber(frame.cursor, frame.end);
  if (!number.end || (number.end < frame.end && !endsNumber(*number.end)))
    failNumber(frame.cursor, "is not a number");
  if (!std::isfinite(number.value)) failNumber(frame.cursor, "is too large");
  token_.kind = Token::Kind::Number;
  token_.number = number.value;
  frame.cursor = number.end;
}

void TokenStream::lexWord() {
  Frame& frame = frames_.back();
  const char* p = frame.cursor;
  while (p < frame.end && (startsWord(*p) || isDigit(*p))) ++p;
  token_.kind = Token::Kind::Word;
  token_.text.assign(frame.cursor, p);
  frame.cursor = p;
}

void TokenStream::lexString() {
  Frame& frame = frames_.back();
  const char* const quoteMark = frame.cursor;
  const char* p = quoteMark + 1;
  for (;;) {
    // A run without anything special is copied at once.
    const char* const run = p;
    while (p < frame.end && *p != '"' && *p != '\\' && *p != '\n') ++p;
    token_.text.append(run, p);
    if (p == frame.end) fail(quoteMark, "this string is never closed");
    if (*p == '\n') fail(quoteMark, "this string is not closed on its line");
    if (*p++ == '"') break;
    if (p == frame.end) fail(quoteMark, "this string is never closed");
    if (*p == '\n')
      ++p;  // a backslash at the end of the line continues the string on the next one
    else
      token_.text += lexEscape(p);
  }
  token_.kind = Token::Kind::String;
  frame.cursor = p;
}

/// The character that is meant by what follows a backslash at p.
char TokenStream::lexEscape(const char*& p) {
  const Frame& frame = frames_.back();
  if (frame.end - p >= 3 && isDigit(p[0]) && isDigit(p[1]) && isDigit(p[2])) {
    const int code = (p[0] - '0') * 100 + (p[1] - '0') * 10 + (p[2] - '0');  // decimal, as PBRT-v2
    if (code > 255) fail(p - 1, fmt::format("the escape \\{} is above 255", std::string(p, 3)));
    p += 3;
    return static_cast<char>(code);
  }
  const char c = *p++;
  switch (c) {
    case 'n':
      return '\n';
    case 't':
      return '\t';
    case 'r':
      return '\r';
    case 'b':
      return '\b';
    case 'f':
      return '\f';
    default:
      return c;
  }
}

std::size_t TokenStream::countNumbersAhead() {
  BRUME_CHECK(!isPeeked_);
  Frame& frame = frames_.back();
  std::size_t count = 0;
  unsigned char before = ' ';
  constexpr std::ptrdiff_t kWindow = std::ptrdiff_t{1} << 20;
  for (const char* window = frame.cursor; window < frame.end; window += kWindow) {
    const std::ptrdiff_t size = std::min<std::ptrdiff_t>(kWindow, frame.end - window);
    const auto* bytes = reinterpret_cast<const unsigned char*>(window);
    const void* bracket = std::memchr(window, ']', static_cast<std::size_t>(size));
    const std::ptrdiff_t n = bracket ? static_cast<const char*>(bracket) - window : size;
    // A number starts where something follows a blank.
    if (n > 0) count += before <= ' ' && bytes[0] > ' ';
    std::uint32_t starts = 0;
    for (std::ptrdiff_t i = 1; i < n; ++i) starts += (bytes[i] > ' ') & (bytes[i - 1] <= ' ');
    count += starts;
    if (bracket) return count;
    before = bytes[n - 1];
    if (window != frame.cursor) frame.file.forget(window, window + size);
  }
  return 0;
}

}  // namespace brume
