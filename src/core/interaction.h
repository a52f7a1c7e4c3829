// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/math.h"
#include "core/ray.h"
#include "core/texture.h"

namespace brume {

class Material;
class AreaLight;

/// Partial derivatives of a surface position and normal by its parameters u, v.
struct SurfaceDerivatives {
  Vec3 dpdu{0}, dpdv{0};
  Vec3 dndu{0}, dndv{0};
};

/// A point on a surface, in render space (the scene's world moved so that the camera is at the
/// origin).
struct SurfaceInteraction {
  Vec3 p{0};
  Vec3 pError{0};  ///< bound on the absolute error of p, per axis
  Vec3 n{0, 0,
         1};  ///< geometric normal, unit; flipped by ReverseOrientation xor a mirroring transform
  Vec2 uv{0};
  SurfaceDerivatives geometry;
  Vec3 ns{
      0, 0,
      1};  ///< shading normal, unit, before bump mapping; not turned to the side of n (as PBRT-v2)
  SurfaceDerivatives shading;
  Vec3 wo{0};  ///< unit, away from the surface, towards where the ray came from
  float time = 0;
  const Material* material = nullptr;
  const AreaLight* areaLight = nullptr;
  TextureContext texture;  ///< footprint, filled by computeFootprint

  /// Origin for a ray that leaves towards w: p moved out of its error box along n. Source: Pharr,
  /// Jakob, Humphreys 2016, 3.9.5.
  Vec3 offsetOrigin(const Vec3& w) const;
  /// A ray that leaves towards the unit vector w.
  Ray spawnRay(const Vec3& w, float tMax = kInfinity) const {
    return {offsetOrigin(w), w, tMax, time};
  }
  /// The texture footprint from the ray's differentials (Igehy 1999), and texture.p, uv.
  void computeFootprint(const FootprintRay& ray, const Vec3& sceneOrigin);
};

/// p moved along the unit normal n by the error box pError, to the side of w, then rounded away
/// from p.
Vec3 offsetRayOrigin(const Vec3& p, const Vec3& pError, const Vec3& n, const Vec3& w);

}  // namespace brume
