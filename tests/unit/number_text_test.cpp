// SPDX-License-Identifier: Apache-2.0
#include "core/io/number_text.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <string>

#include "core/rng.h"

namespace brume {
namespace {

/// Value of a text that is a number as a whole; NaN otherwise.
double parse(const std::string& text) {
  const NumberText number = parseNumber(text.data(), text.data() + text.size());
  return number.end == text.data() + text.size() ? number.value
                                                 : std::numeric_limits<double>::quiet_NaN();
}

TEST(NumberText, AcceptsTheGrammar) {
  EXPECT_EQ(parse("0"), 0);
  EXPECT_EQ(parse("-0"), 0);
  EXPECT_TRUE(std::signbit(parse("-0")));
  EXPECT_EQ(parse("+12"), 12);
  EXPECT_EQ(parse("1."), 1);
  EXPECT_EQ(parse(".5"), 0.5);
  EXPECT_EQ(parse("-.5e1"), -5);
  EXPECT_EQ(parse("+1.E+2"), 100);
  EXPECT_EQ(parse("12345678901234567890123"), 12345678901234567890123.0);
  EXPECT_EQ(parse("0.00000000000000000000000000001"), 1e-29);
}

TEST(NumberText, RefusesWhatIsNone) {
  for (const char* text : {"", "-", "+", ".", "-.", "e5", "1e", "1e+", "nan", "inf", "-inf", "0x10",
                           "1.2.3", "--1", "+-1", "1_000"})
    EXPECT_TRUE(std::isnan(parse(text))) << text;
}

TEST(NumberText, TooLargeIsInfiniteAndTooSmallIsZero) {
  EXPECT_EQ(parse("1e999"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse("-1e99999999999999999999"), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse(std::string(400, '9')), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse("1e-999"), 0);
  EXPECT_EQ(parse("0.0e999999"), 0);
  EXPECT_EQ(parse("0." + std::string(400, '0') + "1e+10"), 0);
}

TEST(NumberText, RoundsCorrectly) {
  // Every double comes back from its text, whichever way it is read.
  Rng rng(7);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = rng.bits64();
    const double value = std::bit_cast<double>(bits);
    if (!std::isfinite(value)) continue;
    EXPECT_EQ(parse(fmt::format("{:.17g}", value)), value);
    const double plain = static_cast<double>(static_cast<std::int64_t>(bits) % 1'000'000'000) / 1e5;
    EXPECT_EQ(parse(fmt::format("{:.5f}", plain)), plain);
  }
}

}  // namespace
}  // namespace brume
