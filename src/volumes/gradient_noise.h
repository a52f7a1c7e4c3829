// SPDX-License-Identifier: Apache-2.0
// Gradient noise whose range over any box is bounded.
#pragma once

#include <cstdint>

#include "core/math.h"

namespace brume {

/// Values from lo to hi.
struct ValueRange {
  double lo = 0, hi = 0;
};
struct Bounds3d {
  Vec3d lo{0}, hi{0};
};

/// No noise is larger: along each axis the mean of the corners' distances, (1 - fade(x)) x +
/// fade(x) (1 - x), is at most 1/2, and no component of a gradient exceeds 1.
inline constexpr double kLargestNoise = 1.5;

/// Smooth noise, rarely beyond 1 and never beyond 1.5, twice continuously differentiable: at the
/// points of the integer lattice it is 0 with a gradient drawn from the twelve (+-1, +-1, 0), ...,
/// and between them the eight linear functions are blended by 6 t^5 - 15 t^4 + 10 t^3. Source:
/// Perlin 2002, Improving Noise. Test: cloud_test.
class GradientNoise {
 public:
  explicit GradientNoise(std::uint64_t seed) : seed_(seed) {}
  double value(const Vec3d& p) const;
  /// Holds the values in the box, by interval arithmetic in every lattice cell it touches; the
  /// largest that there is for boxes that touch many.
  ValueRange range(const Bounds3d& box) const;

 private:
  struct Corner {
    double g[3];  ///< its gradient
  };
  Corner corner(double x, double y, double z) const;
  ValueRange rangeInCell(const Vec3d& cell, const Bounds3d& part) const;

  std::uint64_t seed_;
};

/// Octaves of noise, sum_k gain^k noise_k(2^k p) / sum_k gain^k.
class FractalNoise {
 public:
  FractalNoise(std::uint64_t seed, int octaves, double gain);
  double value(const Vec3d& p) const;
  ValueRange range(const Bounds3d& box) const;

 private:
  GradientNoise noise_;
  int octaves_;
  double gain_, scale_;
};

}  // namespace brume
