// SPDX-License-Identifier: Apache-2.0
#include "main/option_values.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "core/error.h"

namespace brume {
namespace {

[[noreturn]] void fail(const WrittenOption& option, const std::string& wanted) {
  throw SceneError(
      fmt::format("{} cannot be '{}': it wants {}", option.name, option.value, wanted));
}

/// The whole of `text` as a number, or nothing.
template <class T>
std::optional<T> parseAll(std::string_view text) {
  T value{};
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || rest != end) return std::nullopt;
  return value;
}

}  // namespace

std::int64_t parseWhole(const WrittenOption& option, std::int64_t lo, std::int64_t hi) {
  const auto value = parseAll<std::int64_t>(option.value);
  if (!value || *value < lo || *value > hi)
    fail(option, fmt::format("a whole number from {} to {}", lo, hi));
  return *value;
}

std::uint64_t parseSeed(const WrittenOption& option) {
  const auto value = parseAll<std::uint64_t>(option.value);
  if (!value) fail(option, "a whole number from 0 to 2^64 - 1");
  return *value;
}

double parseNumber(const WrittenOption& option, Zero zero) {
  const auto value = parseAll<double>(option.value);
  const bool isLargeEnough =
      value && std::isfinite(*value) && (zero == Zero::Allowed ? *value >= 0 : *value > 0);
  if (!isLargeEnough)
    fail(option, zero == Zero::Allowed ? "a number that is not negative" : "a number above 0");
  return *value;
}

double parseDuration(const WrittenOption& option) {
  std::string_view number = option.value;
  double unit = 1;
  if (!number.empty()) {
    const char last = number.back();
    if (last == 'm') unit = 60;
    if (last == 'h') unit = 3600;
    if (last == 's' || last == 'm' || last == 'h') number.remove_suffix(1);
  }
  const auto value = parseAll<double>(number);
  if (!value || !std::isfinite(*value) || *value <= 0)
    fail(option, "a time such as 60s, 2m or 1.5h (seconds when no unit is given)");
  return *value * unit;
}

Vec2i parseResolution(const WrittenOption& option) {
  const std::string_view text = option.value;
  const std::size_t x = text.find('x');
  const auto width = parseAll<int>(text.substr(0, x));
  const auto height =
      x == std::string_view::npos ? std::nullopt : parseAll<int>(text.substr(x + 1));
  if (!width || !height || *width < 1 || *height < 1)
    fail(option, "width and height in pixels, such as 640x480");
  return {*width, *height};
}

std::array<float, 4> parseCrop(const WrittenOption& option) {
  std::array<float, 4> crop{};
  std::string_view rest = option.value;
  bool isValid = true;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t comma = rest.find(',');
    const auto value = parseAll<float>(rest.substr(0, comma));
    isValid = isValid && value && *value >= 0 && *value <= 1 &&
              (comma == std::string_view::npos) == (i == 3);
    if (!isValid) break;
    crop[i] = *value;
    rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 1);
  }
  if (!isValid || crop[0] >= crop[1] || crop[2] >= crop[3])
    fail(option, "x0,x1,y0,y1: fractions of the image from 0 to 1 with x0 < x1 and y0 < y1");
  return crop;
}

}  // namespace brume
