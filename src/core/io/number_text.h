// SPDX-License-Identifier: Apache-2.0
// Numbers as text: [-+]? (digits | digits.digits* | .digits) ([eE][-+]?digits)?, in double; float
// values are rounded from there, as PBRT-v2 does.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>

namespace brume {

/// A number at the start of a text.
struct NumberText {
  const char* end = nullptr;  ///< behind the number; null when the text does not start with one
  double value = 0;           ///< infinite when it is too large for a double
};

constexpr bool isDigit(char c) { return c >= '0' && c <= '9'; }
constexpr bool mayStartNumber(char c) { return isDigit(c) || c == '.' || c == '-' || c == '+'; }

/// The general case of parseNumber: any number of digits, any exponent.
NumberText parseLongNumber(const char* p, const char* end);

/// The number that starts at p. A mantissa below 2^53 with a power of ten up to 10^22 is exact in
/// one division or product (Clinger 1990); everything else goes to std::from_chars.
inline NumberText parseNumber(const char* p, const char* end) {
  static constexpr double kPowersOfTen[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                            1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                            1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  const char* const start = p;
  const bool negative = p < end && *p == '-';
  if (p < end && (*p == '-' || *p == '+')) ++p;
  const char* const firstDigit = p;
  std::uint64_t mantissa = 0;
  while (p < end && isDigit(*p)) mantissa = mantissa * 10 + static_cast<std::uint64_t>(*p++ - '0');
  std::ptrdiff_t digits = p - firstDigit;
  std::ptrdiff_t exponent = 0;
  if (p < end && *p == '.') {
    const char* const firstDecimal = ++p;
    while (p < end && isDigit(*p))
      mantissa = mantissa * 10 + static_cast<std::uint64_t>(*p++ - '0');
    exponent = firstDecimal - p;
    digits -= exponent;
  }
  if (digits == 0) return {};
  if (p < end && (*p == 'e' || *p == 'E')) return parseLongNumber(start, end);
  constexpr std::ptrdiff_t kSafeDigits = 19;  // they fit in 64 bits
  if (digits > kSafeDigits || mantissa > (std::uint64_t{1} << 53) || exponent < -22)
    return parseLongNumber(start, end);
  const double magnitude = static_cast<double>(mantissa) / kPowersOfTen[-exponent];
  return {p, negative ? -magnitude : magnitude};
}

}  // namespace brume
