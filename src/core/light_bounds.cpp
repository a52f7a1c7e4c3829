// SPDX-License-Identifier: Apache-2.0
#include "core/light_bounds.h"

namespace brume {

DirectionCone unionOf(const DirectionCone& a, const DirectionCone& b) {
  if (a.isEverything() || b.isEverything()) return {};
  const Vec3d axisA(a.axis), axisB(b.axis);
  const double halfA = std::acos(std::min(1.0, double{a.cosine}));
  const double halfB = std::acos(std::min(1.0, double{b.cosine}));
  // The angle between the axes, without cancellation.
  const double between = 2 * std::atan2(length(axisA - axisB), length(axisA + axisB));
  if (between + halfB <= halfA) return a;
  if (between + halfA <= halfB) return b;

  const double half = 0.5 * (between + halfA + halfB);
  const Vec3d normal = cross(cross(axisA, axisB), axisA);
  const double l = length(normal);
  if (half >= M_PI || !(l > 0)) return {};
  // From the border of a on the far side of b, by `half` towards b.
  const double turn = half - halfA;
  const Vec3d axis = axisA * std::cos(turn) + normal * (std::sin(turn) / l);
  // A little wider, for rounding to float.
  return {Vec3(normalize(axis)), static_cast<float>(std::cos(std::min(M_PI, half + 1e-6)))};
}

LightBounds& LightBounds::operator+=(const LightBounds& o) {
  if (!(o.intensity > 0)) return *this;
  if (!(intensity > 0)) return *this = o;
  box.extend(o.box);
  axes = unionOf(axes, o.axes);
  cosEmission = std::min(cosEmission, o.cosEmission);
  intensity += o.intensity;
  return *this;
}

}  // namespace brume
