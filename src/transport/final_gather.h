// SPDX-License-Identifier: Apache-2.0
// Indirect light on a surface by rays to its surroundings, whose radiance is known.
#pragma once

#include "core/bsdf.h"
#include "core/integrator.h"
#include "transport/radiance_photons.h"

namespace brume {

/// Indirect light by rays to radiance photons. Half of the rays are drawn by the BSDF, half from
/// cones around the directions of the nearest indirect photons; the power heuristic weighs both.
///   L = Int f(wo, wi) Lo(hit) Tr |wi.ns| dwi, without specular lobes      [W m^-2 sr^-1]
///   density of the second half: mean over the photons of (wi in cone_i) / (2 Pi (1 - cos angle))
/// Rays go on through mirrors and glass; those that leave the scene bring nothing. Bias: that of
/// the radiance photons, no more. Source: Jensen 2001; PBRT-v2. Immutable and thread-safe. Test:
/// photonmap_test.
class FinalGather {
 public:
  struct Settings {
    int samples = 16;         ///< of each half
    float cosAngle = 0.985f;  ///< of the cones' half-angle
    int maxBounces = 5;       ///< specular ones of a ray
  };
  FinalGather(const Scene& scene, const SurfacePhotonMap& indirect, const RadiancePhotons& radiance,
              const Settings& settings)
      : scene_(scene), indirect_(indirect), radiance_(radiance), settings_(settings) {}

  /// Reflected indirect radiance towards query.hit.wo.
  Rgb reflected(const SurfaceQuery& query, const Bsdf& bsdf, RenderContext& context) const;

 private:
  class Cones;
  Rgb arriving(const SurfaceQuery& query, const Vec3& wi, RenderContext& context) const;

  const Scene& scene_;
  const SurfacePhotonMap& indirect_;
  const RadiancePhotons& radiance_;
  Settings settings_;
};

}  // namespace brume
