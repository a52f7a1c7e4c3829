// SPDX-License-Identifier: Apache-2.0
#include "core/parse/token_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace brume {
namespace {

TokenStream streamOf(std::string_view text, const std::string& directory = "") {
  return TokenStream(SourceFile(InputFile::borrow(text), internFileName("t.pbrt")), directory);
}

/// "W:Shape S:name N:1.5 [ ] E", each with line:column when asked for.
std::string listTokens(TokenStream& stream, bool withPlaces = false) {
  std::string all;
  for (;;) {
    const Token t = stream.next();
    if (!all.empty()) all += ' ';
    if (withPlaces)
      all += std::to_string(t.where.line) + ":" + std::to_string(t.where.column) + " ";
    switch (t.kind) {
      case Token::Kind::Word:
        all += "W:" + t.text;
        break;
      case Token::Kind::String:
        all += "S:" + t.text;
        break;
      case Token::Kind::Number:
        all += "N:" + std::to_string(static_cast<int>(t.number));
        break;
      case Token::Kind::Open:
        all += '[';
        break;
      case Token::Kind::Close:
        all += ']';
        break;
      case Token::Kind::End:
        return all + "E";
    }
  }
}

std::string tokensOf(std::string_view text) {
  TokenStream stream = streamOf(text);
  return listTokens(stream);
}

/// "line:column: message" of the error that the text causes.
std::string errorOf(std::string_view text) {
  try {
    TokenStream stream = streamOf(text);
    listTokens(stream);
  } catch (const SceneError& e) {
    return toString(e.where()) + ": " + e.what();
  }
  return "no error";
}

TEST(TokenStream, SplitsWithoutNeedOfBlanks) {
  EXPECT_EQ(tokensOf("Shape\"a\"[1 2]Word_3 # rest \n4#\n5"),
            "W:Shape S:a [ N:1 N:2 ] W:Word_3 N:4 N:5 E");
  EXPECT_EQ(tokensOf(""), "E");
  EXPECT_EQ(tokensOf("# only a comment"), "E");
  EXPECT_EQ(tokensOf("\xef\xbb\xbfWorldBegin"), "W:WorldBegin E");
}

TEST(TokenStream, KnowsLinesAndColumns) {
  TokenStream stream = streamOf("Ab\r\n  [ 1\n\n\"x\"\t7");
  EXPECT_EQ(listTokens(stream, true), "1:1 W:Ab 2:3 [ 2:5 N:1 4:1 S:x 4:5 N:7 4:6 E");
}

TEST(TokenStream, ResolvesEscapes) {
  EXPECT_EQ(tokensOf(R"("a\"b\\c\n\t\065\q")"), "S:a\"b\\c\n\tAq E");
  EXPECT_EQ(tokensOf("\"a\\\nb\""), "S:ab E");  // a line continued
  EXPECT_EQ(errorOf(R"("ab\256")"), "t.pbrt:1:4: the escape \\256 is above 255");
}

TEST(TokenStream, PointsAtWhatIsWrong) {
  EXPECT_EQ(errorOf("a\n \"open\nb"), "t.pbrt:2:2: this string is not closed on its line");
  EXPECT_EQ(errorOf("\"open"), "t.pbrt:1:1: this string is never closed");
  EXPECT_EQ(errorOf("\"open\\"), "t.pbrt:1:1: this string is never closed");
  EXPECT_EQ(errorOf("a { b"), "t.pbrt:1:3: unexpected character '{'");
  EXPECT_EQ(errorOf("a \x01"), "t.pbrt:1:3: unexpected character '\\x01'");
  EXPECT_EQ(errorOf("1.2.3"), "t.pbrt:1:1: '1.2.3' is not a number");
  EXPECT_EQ(errorOf("1 -inf"), "t.pbrt:1:3: '-inf' is not a number");
  EXPECT_EQ(errorOf("1e999"), "t.pbrt:1:1: '1e999' is too large");
}

TEST(TokenStream, ShortensLongTextInMessages) {
  const std::string text = "1" + std::string(100000, 'x');
  EXPECT_EQ(errorOf(text), "t.pbrt:1:1: '1" + std::string(39, 'x') + "...' is not a number");
}

TEST(TokenStream, CountsNumbersOfAList) {
  TokenStream stream = streamOf(" 1 2\n3 4.5 -6] 7");
  EXPECT_EQ(stream.countNumbersAhead(), 5u);
  TokenStream open = streamOf("1 2 3");
  EXPECT_EQ(open.countNumbersAhead(), 0u);
}

/// Files that exist while a test runs.
class IncludeTest : public testing::Test {
 protected:
  void SetUp() override {
    directory_ =
        std::filesystem::path(testing::TempDir()) / ("brume_include_" + std::to_string(::getpid()));
    std::filesystem::create_directory(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(directory_ / name) << text;
  }
  /// Tokens of a text where each word Include with its string is followed.
  std::string expand(std::string_view text) const {
    TokenStream stream = streamOf(text, directory_.string());
    std::string all;
    for (;;) {
      const Token t = stream.next();
      if (t.kind == Token::Kind::End) return all;
      if (t.kind == Token::Kind::Word && t.text == "Include") {
        const Token name = stream.next();
        stream.include(name.text, name.where);
      } else {
        all += t.kind == Token::Kind::Number ? std::to_string(static_cast<int>(t.number)) : t.text;
        all += t.kind == Token::Kind::Open ? "[" : t.kind == Token::Kind::Close ? "]" : " ";
      }
    }
  }
  std::string errorOfInclude(std::string_view text) const {
    try {
      expand(text);
    } catch (const SceneError& e) {
      return e.what();
    }
    return "no error";
  }
  std::filesystem::path directory_;
};

TEST_F(IncludeTest, IsOneStreamOfTokens) {
  write("a", "A [1 2");
  write("b", "Include \"a\" 3");
  EXPECT_EQ(expand("x Include \"b\" 4] y"), "x A [1 2 3 4 ]y ");
}

TEST_F(IncludeTest, FindsCyclesAndMissingFiles) {
  write("self", "Include \"self\"");
  write("a", "Include \"b\"");
  write("b", "\n Include \"a\"");
  EXPECT_THAT(errorOfInclude("Include \"self\""), testing::HasSubstr("self' includes itself"));
  EXPECT_THAT(errorOfInclude("Include \"a\""), testing::HasSubstr("a:1:9, then here"));
  EXPECT_THAT(errorOfInclude("Include \"c\""), testing::HasSubstr("No such file"));
  EXPECT_THAT(errorOfInclude("Include \".\""), testing::HasSubstr("it is a directory"));
  EXPECT_THAT(errorOfInclude("Include \"/dev/zero\""), testing::HasSubstr("no regular file"));
  EXPECT_THAT(errorOfInclude("Include \"a\\000b\""), testing::HasSubstr("zero byte"));
}

TEST_F(IncludeTest, LimitsTheDepth) {
  for (int i = 0; i < 40; ++i)
    write(std::to_string(i), "Include \"" + std::to_string(i + 1) + "\"");
  EXPECT_EQ(errorOfInclude("Include \"0\""), "Include is nested more than 32 deep");
}

TEST_F(IncludeTest, ReadsLargeFilesMapped) {
  // Above the size from which files are mapped; memory behind the cursor is let go of meanwhile.
  std::string text = "[";
  constexpr int kNumbers = 1'500'000;
  for (int i = 0; i < kNumbers; ++i) text += std::to_string(i) + (i % 10 == 9 ? "\n" : " ");
  write("large", text + "] End");
  TokenStream stream = streamOf("Include \"large\"", directory_.string());
  stream.next();
  const Token name = stream.next();
  stream.include(name.text, name.where);
  ASSERT_EQ(stream.next().kind, Token::Kind::Open);
  EXPECT_EQ(stream.countNumbersAhead(), std::size_t{kNumbers});
  double sum = 0;
  stream.readNumbers([&](double v) {
    sum += v;
    return static_cast<const char*>(nullptr);
  });
  EXPECT_EQ(sum, 0.5 * kNumbers * (kNumbers - 1.0));
  EXPECT_EQ(stream.next().where.line, 150'001u);
  EXPECT_EQ(stream.next().where.column, 3u);
}

}  // namespace
}  // namespace brume
