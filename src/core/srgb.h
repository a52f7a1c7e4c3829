// SPDX-License-Identifier: Apache-2.0
// The transfer curve of sRGB (IEC 61966-2-1).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace brume {

/// Linear light in [0, 1] to its sRGB code value in [0, 1].
inline float encodeSrgb(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.f / 2.4f) - 0.055f;
}
/// The inverse of encodeSrgb.
inline float decodeSrgb(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}
/// To 8 bits, clipped to [0, 1]; NaN becomes 0.
inline std::uint8_t encodeSrgb8(float linear) {
  const float clipped = linear > 0.f ? std::min(linear, 1.f) : 0.f;
  return static_cast<std::uint8_t>(std::lround(255.f * encodeSrgb(clipped)));
}

}  // namespace brume
