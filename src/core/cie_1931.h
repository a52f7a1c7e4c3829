// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

namespace brume {

inline constexpr std::size_t kCieSampleCount = 471;
inline constexpr float kCieFirstWavelength = 360;  ///< [nm], then every nm up to 830

/// The CIE 1931 matching functions of the 2-degree observer at one wavelength.
struct CieSample {
  float x, y, z;
};
extern const std::array<CieSample, kCieSampleCount> kCie1931;

}  // namespace brume
