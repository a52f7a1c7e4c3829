// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/math.h"

namespace brume {

/// The angle by which light is turned, as 1 - cos and 1 + cos, each without cancellation: phase
/// functions peak where one of them is tiny.
struct ScatteringAngle {
  float oneMinusCos = 1;
  float onePlusCos = 1;

  /// wo to the viewer, wi to where the light comes from; cos = -dot(wo, wi). With unit vectors
  /// 1 - cos = |wo + wi|^2 / 2.
  static ScatteringAngle between(const Vec3& wo, const Vec3& wi) {
    return {0.5f * lengthSquared(wo + wi), 0.5f * lengthSquared(wo - wi)};
  }
  float cos() const { return 0.5f * (onePlusCos - oneMinusCos); }
};

struct PhaseSample {
  Vec3 wi{0};       ///< unit, from the scattering point towards where the light comes from
  float value = 0;  ///< p(wo, wi) [1/sr]
  float pdf = 0;    ///< per solid angle
};

/// A phase function, normalised to 1 over the sphere. Sign convention: wo and wi both point away
/// from the scattering point (wo to the viewer, wi to the light's origin), so forward scattering is
/// wi = -wo, and the mean of -dot(wo, wi) is g. In PBRT-v2's terms w = wo and w' = -wi is the
/// direction in which light travels; g > 0 is forward in both.
class PhaseFunction {
 public:
  virtual ~PhaseFunction() = default;
  /// p as a function of the angle [1/sr].
  virtual float value(const ScatteringAngle& angle) const = 0;
  /// Draws an angle with the density 2 pi value() per cosine; uLobe chooses among the parts of a
  /// mixture.
  virtual ScatteringAngle sampleAngle(float uLobe, float u) const = 0;
  /// Mean cosine.
  virtual float g() const = 0;
  /// The largest value [1/sr].
  virtual float peak() const = 0;
  /// g when this is the Henyey-Greenstein function (0: isotropic), which has kernels of its own.
  virtual std::optional<float> henyeyGreenstein() const { return std::nullopt; }

  /// [1/sr]
  float p(const Vec3& wo, const Vec3& wi) const { return value(ScatteringAngle::between(wo, wi)); }
  /// A direction with pdf = value: phase functions are sampled exactly.
  PhaseSample sample(const Vec3& wo, float uLobe, Vec2 u) const;
};

/// Unit vector at the given scattering angle from wo (so that -dot(wo, result) is its cosine) and
/// azimuth 2 pi u.
Vec3 scatteredDirection(const Vec3& wo, const ScatteringAngle& angle, float u);

}  // namespace brume
