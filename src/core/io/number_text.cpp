// SPDX-License-Identifier: Apache-2.0
#include "core/io/number_text.h"

#include <limits>

namespace brume {

namespace {

/// Whether a number that std::from_chars found out of range is too large, not too small: by the
/// decimal position of its first significant digit.
bool isHuge(const char* p, const char* end) {
  long long position = 0;  // of the first digit that is not 0, in powers of ten
  bool significant = false, fraction = false;
  for (; p < end && *p != 'e' && *p != 'E'; ++p) {
    if (*p == '.') fraction = true;
    if (!isDigit(*p)) continue;
    if (*p != '0') significant = true;
    if (!fraction && significant) ++position;
    if (fraction && !significant) --position;
  }
  long long exponent = 0;
  if (p < end) {
    ++p;
    const bool negative = p < end && *p == '-';
    if (p < end && (*p == '-' || *p == '+')) ++p;
    constexpr long long kFarOut = 1'000'000'000'000;
    for (; p < end && exponent < kFarOut; ++p) exponent = exponent * 10 + (*p - '0');
    if (negative) exponent = -exponent;
  }
  return significant && position + exponent > 0;
}

}  // namespace

NumberText parseLongNumber(const char* p, const char* end) {
  const char* const first = p < end && *p == '+' ? p + 1 : p;  // from_chars knows no plus sign
  double value = 0;
  const auto [last, error] = std::from_chars(first, end, value);
  if (error == std::errc::invalid_argument) return {};
  if (error == std::errc::result_out_of_range) {
    const double magnitude = isHuge(first, last) ? std::numeric_limits<double>::infinity() : 0.0;
    value = *first == '-' ? -magnitude : magnitude;
  }
  return {last, value};
}

}  // namespace brume
