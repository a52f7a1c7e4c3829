// SPDX-License-Identifier: Apache-2.0
// Linear Rec. 709 colour: radiance, power, reflectance or a coefficient per channel.
#pragma once

#include <algorithm>
#include <cmath>

namespace brume {

/// Three channels of a spectral quantity; its unit is that of the quantity it holds.
struct Rgb {
  float r = 0, g = 0, b = 0;

  constexpr Rgb() = default;
  constexpr explicit Rgb(float v) : r(v), g(v), b(v) {}
  constexpr Rgb(float r_, float g_, float b_) : r(r_), g(g_), b(b_) {}

  constexpr float operator[](int i) const { return i == 0 ? r : i == 1 ? g : b; }
  constexpr float& operator[](int i) { return i == 0 ? r : i == 1 ? g : b; }

  constexpr Rgb& operator+=(const Rgb& o) { return *this = *this + o; }
  constexpr Rgb& operator-=(const Rgb& o) { return *this = *this - o; }
  constexpr Rgb& operator*=(const Rgb& o) { return *this = *this * o; }
  constexpr Rgb& operator*=(float s) { return *this = *this * s; }
  constexpr Rgb& operator/=(float s) { return *this = *this / s; }
  friend constexpr Rgb operator+(const Rgb& x, const Rgb& y) {
    return {x.r + y.r, x.g + y.g, x.b + y.b};
  }
  friend constexpr Rgb operator-(const Rgb& x, const Rgb& y) {
    return {x.r - y.r, x.g - y.g, x.b - y.b};
  }
  friend constexpr Rgb operator*(const Rgb& x, const Rgb& y) {
    return {x.r * y.r, x.g * y.g, x.b * y.b};
  }
  friend constexpr Rgb operator/(const Rgb& x, const Rgb& y) {
    return {x.r / y.r, x.g / y.g, x.b / y.b};
  }
  friend constexpr Rgb operator*(const Rgb& x, float s) { return {x.r * s, x.g * s, x.b * s}; }
  friend constexpr Rgb operator*(float s, const Rgb& x) { return x * s; }
  friend constexpr Rgb operator/(const Rgb& x, float s) { return {x.r / s, x.g / s, x.b / s}; }
  friend constexpr Rgb operator-(const Rgb& x) { return {-x.r, -x.g, -x.b}; }
  friend constexpr bool operator==(const Rgb&, const Rgb&) = default;

  constexpr bool isBlack() const { return r == 0 && g == 0 && b == 0; }
  bool isFinite() const { return std::isfinite(r) && std::isfinite(g) && std::isfinite(b); }
  constexpr float maxChannel() const { return std::max(r, std::max(g, b)); }
  constexpr float minChannel() const { return std::min(r, std::min(g, b)); }
  constexpr float average() const { return (r + g + b) * (1.f / 3.f); }
  /// Y of Rec. 709 primaries, with the weights PBRT-v2 uses.
  constexpr float luminance() const { return .212671f * r + .715160f * g + .072169f * b; }
};

inline Rgb exp(const Rgb& c) { return {std::exp(c.r), std::exp(c.g), std::exp(c.b)}; }
inline Rgb sqrt(const Rgb& c) { return {std::sqrt(c.r), std::sqrt(c.g), std::sqrt(c.b)}; }
inline Rgb max(const Rgb& c, float lo) {
  return {std::max(c.r, lo), std::max(c.g, lo), std::max(c.b, lo)};
}
inline Rgb min(const Rgb& c, float hi) {
  return {std::min(c.r, hi), std::min(c.g, hi), std::min(c.b, hi)};
}

}  // namespace brume
