// SPDX-License-Identifier: Apache-2.0
// Where a light is and whither it shines, bounded: what light hierarchies are built from.
#pragma once

#include "core/math.h"

namespace brume {

/// All unit vectors within an angle of an axis; all of the sphere by default.
struct DirectionCone {
  Vec3 axis{0, 0, 1};
  float cosine = -1;  ///< of the largest angle to the axis

  static DirectionCone around(const Vec3& w) { return {w, 1}; }
  bool isEverything() const { return cosine <= -1; }
};
/// A cone that holds both.
DirectionCone unionOf(const DirectionCone& a, const DirectionCone& b);

/// Bounds of emitters: from points of `box` they shine in directions that lie within
/// acos(cosEmission) of some direction of `axes`. Render space. Source: Conty Estevez, Kulla 2018.
struct LightBounds {
  Bounds3 box;
  DirectionCone axes;
  float cosEmission = -1;
  /// Largest radiant intensity [W/sr] of the emitters together, by lightWeight().
  double intensity = 0;

  LightBounds& operator+=(const LightBounds& o);
};

}  // namespace brume
