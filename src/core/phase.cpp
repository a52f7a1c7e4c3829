// SPDX-License-Identifier: Apache-2.0
#include "core/phase.h"

#include "core/sampling.h"

namespace brume {

PhaseSample PhaseFunction::sample(const Vec3& wo, float uLobe, Vec2 u) const {
  const ScatteringAngle angle = sampleAngle(uLobe, u.x);
  const float density = value(angle);
  return {scatteredDirection(wo, angle, u.y), density, density};
}

Vec3 scatteredDirection(const Vec3& wo, const ScatteringAngle& angle, float u) {
  // Light that is not turned comes from -wo: that is the pole.
  const Frame frame = Frame::fromZ(-wo);
  const float sine = safeSqrt(angle.oneMinusCos * angle.onePlusCos);
  const Vec2 cs = cosSinOfTurns(u);
  return frame.fromLocal({sine * cs.x, sine * cs.y, angle.cos()});
}

}  // namespace brume
