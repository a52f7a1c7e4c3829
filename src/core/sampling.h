// SPDX-License-Identifier: Apache-2.0
// Warps of uniform random numbers and tabulated distributions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math.h"

namespace brume {

/// Cosine and sine of u turns, u in [0, 1], each in error by less than 1.5e-7.
Vec2 cosSinOfTurns(float u);
/// Unit square to unit disk, concentric (Shirley, Chiu 1997).
Vec2 sampleConcentricDisk(Vec2 u);
/// Upper hemisphere around +z; pdf cos/pi.
Vec3 sampleCosineHemisphere(Vec2 u);
/// Upper hemisphere; pdf 1/(2 pi).
Vec3 sampleUniformHemisphere(Vec2 u);
/// Sphere; pdf 1/(4 pi).
Vec3 sampleUniformSphere(Vec2 u);
/// Cone around +z with half-angle acos(cosThetaMax); pdf coneUniformPdf. Takes 1 - cos to keep
/// precision for narrow cones.
Vec3 sampleUniformCone(Vec2 u, float oneMinusCosThetaMax);
inline float coneUniformPdf(float oneMinusCosThetaMax) {
  return 1.f / (2.f * kPi * oneMinusCosThetaMax);
}
/// Barycentrics (b0, b1) of a triangle, uniform.
Vec2 sampleUniformTriangle(Vec2 u);

/// Weight of the technique with density a against one with density b, beta = 2 (Veach 1997, 9.2.4).
/// Safe for infinite densities.
inline float powerHeuristic(float a, float b) {
  if (std::isinf(a)) return 1.f;
  const float r = b / a;  // no overflow of a * a
  return a > 0.f ? 1.f / (1.f + r * r) : 0.f;
}

/// A piecewise constant density on [0, 1].
class Distribution1D {
 public:
  Distribution1D() = default;
  /// Values >= 0; when all are 0 the density is uniform.
  explicit Distribution1D(std::span<const float> values);
  struct Sample {
    float x = 0;            ///< in [0, 1)
    float pdf = 0;          ///< density at x
    std::size_t index = 0;  ///< of the cell
  };
  Sample sample(float u) const;
  float pdf(float x) const;
  /// Probability of cell i.
  float probability(std::size_t i) const;
  std::size_t size() const { return cdf_.empty() ? 0 : cdf_.size() - 1; }
  double integral() const { return integral_; }

 private:
  /// The last cell that begins at or before u.
  std::size_t cellAt(double u) const;

  std::vector<double> cdf_;  // size + 1
  // For each of as many equal parts of [0, 1], and its end, the cell at its beginning: the search
  // looks at a few neighbours instead of all (Chen, Asau 1974).
  std::vector<std::uint32_t> guide_;
  double integral_ = 0;  // of the density before normalisation, over [0, 1]
};

/// A piecewise constant density on the unit square; first coordinate along rows.
class Distribution2D {
 public:
  Distribution2D() = default;
  Distribution2D(std::span<const float> values, std::size_t width, std::size_t height);
  struct Sample {
    Vec2 p{0};
    float pdf = 0;
  };
  Sample sample(Vec2 u) const;
  float pdf(Vec2 p) const;

 private:
  std::vector<Distribution1D> rows_;
  Distribution1D marginal_;
};

}  // namespace brume
