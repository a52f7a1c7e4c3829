// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/math.h"

namespace brume {

/// A ray o + t d for t in (0, tMax], at one moment. World space unless its user says otherwise; d
/// is normalised in world space, so t is a distance there.
struct Ray {
  Vec3 o{0};
  Vec3 d{0, 0, 1};
  float tMax = kInfinity;
  float time = 0;

  Vec3 operator()(float t) const { return o + d * t; }
};

/// Rays through the neighbouring sample positions, one in x and one in y: the footprint for texture
/// filtering.
struct RayDifferential {
  Vec3 rxOrigin{0}, ryOrigin{0};
  Vec3 rxDirection{0}, ryDirection{0};
};

/// A ray that may know its footprint (camera and specular rays do).
struct FootprintRay : Ray {
  std::optional<RayDifferential> differential;

  FootprintRay() = default;
  explicit FootprintRay(const Ray& ray) : Ray(ray) {}
  FootprintRay(const Ray& ray, const RayDifferential& rd) : Ray(ray), differential(rd) {}

  /// Shrinks the footprint when a pixel takes several samples (PBRT-v2: by 1/sqrt(samples per
  /// pixel)).
  void scaleDifferential(float s) {
    if (!differential) return;
    RayDifferential& rd = *differential;
    rd.rxOrigin = o + (rd.rxOrigin - o) * s;
    rd.ryOrigin = o + (rd.ryOrigin - o) * s;
    rd.rxDirection = d + (rd.rxDirection - d) * s;
    rd.ryDirection = d + (rd.ryDirection - d) * s;
  }
};

}  // namespace brume
