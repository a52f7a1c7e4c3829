// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string_view>

#include "core/math.h"
#include "core/params.h"

namespace brume {

struct PhaseSample {
  Vec3 wi{0};       ///< unit, from the scattering point towards where the light comes from
  float value = 0;  ///< p(wo, wi) [1/sr]
  float pdf = 0;    ///< per solid angle
};

/// A phase function, normalised to 1 over the sphere. Sign convention: wo and wi both point away
/// from the scattering point (wo to the viewer, wi to the light's origin), so forward scattering is
/// wi = -wo, and the mean of -dot(wo, wi) is g. With c = -dot(wo, wi) = cos of the angle by which
/// light is turned.
class PhaseFunction {
 public:
  virtual ~PhaseFunction() = default;
  /// [1/sr]
  virtual float p(const Vec3& wo, const Vec3& wi) const = 0;
  virtual PhaseSample sample(const Vec3& wo, Vec2 u) const = 0;
  /// Mean cosine.
  virtual float g() const = 0;
};

}  // namespace brume
