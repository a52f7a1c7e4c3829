// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/medium_along_ray.h"

namespace brume {

/// The distance from the start of a cubic piece at which Int density is `target` <= `total`, which
/// is Int density over the piece.
inline double invertCubic(const MediumPiece& piece, double target, double total) {
  // De Casteljau's algorithm cuts the cubic at the fraction x: the mean of the first part's
  // coefficients is its integral, the last one the density there.
  const auto& c = piece.c;
  double density = 0;
  const auto integral = [&](double x) {
    const double y = 1 - x;
    const double a0 = y * c[0] + x * c[1], a1 = y * c[1] + x * c[2], a2 = y * c[2] + x * c[3];
    const double b0 = y * a0 + x * a1, b1 = y * a1 + x * a2;
    density = y * b0 + x * b1;
    return 0.25 * x * (c[0] + a0 + b0 + density);
  };
  const double length = piece.t1 - piece.t0;
  return length *
         invertMonotone(
             integral, [&](double) { return density; }, 1, target / length, total / length);
}

}  // namespace brume
