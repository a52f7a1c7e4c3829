// SPDX-License-Identifier: Apache-2.0
// Gradient noise and its sums over octaves. Source: Perlin 2002, Improving Noise.
#pragma once

#include "core/math.h"

namespace brume {

/// Gradient noise of period 256 in each axis, roughly in [-1, 1], zero at integer points.
float noise(const Vec3& p);

/// Sum of omega^i noise(1.99^i p) over i < octaves; octaves finer than the footprint (dpdx, dpdy:
/// change of p to the next samples) are left out, the last one fades.
float fbm(const Vec3& p, const Vec3& dpdx, const Vec3& dpdy, float omega, int octaves);
/// The same sum over |noise|; octaves left out count with 0.2, the mean of |noise|.
float turbulence(const Vec3& p, const Vec3& dpdx, const Vec3& dpdy, float omega, int octaves);

}  // namespace brume
