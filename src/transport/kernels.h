// SPDX-License-Identifier: Apache-2.0
// Kernels of density estimation, each with integral 1 over its ball: Silverman's biweight. Both
// work with squares, of the radius r > 0 and of the distance d.
#pragma once

#include <algorithm>

#include "core/math.h"

namespace brume {

/// K2(d; r) = 3/(pi r^2) (1 - d^2/r^2)^2 for d < r, else 0  [length^-2]; Int K2 dA = 1.
class DiscKernel {
 public:
  explicit DiscKernel(float radius2)
      : inverseRadius2_(1.f / radius2), peak_(3.f * kInvPi * inverseRadius2_) {}
  float operator()(float d2) const {
    return peak_ * sqr(std::max(0.f, 1.f - d2 * inverseRadius2_));
  }

 private:
  float inverseRadius2_, peak_;
};

/// K3(d; r) = 105/(32 pi r^3) (1 - d^2/r^2)^2 for d < r, else 0  [length^-3]; Int K3 dV = 1.
class BallKernel {
 public:
  explicit BallKernel(float radius2)
      : inverseRadius2_(1.f / radius2),
        peak_(105.f / 32.f * kInvPi * inverseRadius2_ / std::sqrt(radius2)) {}
  float operator()(float d2) const {
    return peak_ * sqr(std::max(0.f, 1.f - d2 * inverseRadius2_));
  }

 private:
  float inverseRadius2_, peak_;
};

/// The part of BallKernel's integral on the near side of a plane at the signed distance u r from
/// the centre: its marginal is 35/32 (1 - u^2)^3.
inline float ballKernelBefore(float u) {
  u = std::clamp(u, -1.f, 1.f);
  const float u2 = u * u;
  return 0.5f + 35.f / 32.f * u * (1 - u2 * (1 - u2 * (0.6f - u2 / 7.f)));
}

/// An estimate blurred by K has the bias c r^2 times the Laplacian of the exact density (over the
/// disc perpendicular to the ray, or in space), up to O(r^4): c = Int K(x) x_1^2 dx / (2 r^2).
inline constexpr float kDiscKernelBias = 1.f / 16.f;
inline constexpr float kBallKernelBias = 1.f / 18.f;

}  // namespace brume
