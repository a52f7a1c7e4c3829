// SPDX-License-Identifier: Apache-2.0
#include "core/volume.h"

#include "core/medium_along_ray.h"

namespace brume {

namespace {

/// De Casteljau: only convex combinations, so values stay between the coefficients.
double evaluateBernstein(const std::array<double, 4>& c, double x) {
  const double y = 1 - x;
  const double a0 = y * c[0] + x * c[1], a1 = y * c[1] + x * c[2], a2 = y * c[2] + x * c[3];
  return y * (y * a0 + x * a1) + x * (y * a1 + x * a2);
}

}  // namespace

double MediumPiece::density(double t) const {
  if (form == Form::Tracked) return 0;
  if (form == Form::Exponential)
    return c[1] == 0 ? c[0] : c[0] * std::exp(-c[1] * (t - (c[1] > 0 ? t0 : t1)));
  return evaluateBernstein(c, std::clamp((t - t0) / (t1 - t0), 0.0, 1.0));
}

double MediumPiece::integral(double a, double b) const {
  if (form == Form::Tracked) return 0;
  if (form == Form::Exponential)
    return density(c[1] > 0 ? a : b) * (b - a) * exponentialMean(std::abs(c[1]) * (b - a));
  if (a == t0 && b == t1) return 0.25 * (b - a) * (c[0] + c[1] + c[2] + c[3]);
  // Two Gauss points integrate a cubic exactly, with positive weights.
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
  return half * (density(middle - half * kGauss2) + density(middle + half * kGauss2));
}

}  // namespace brume
