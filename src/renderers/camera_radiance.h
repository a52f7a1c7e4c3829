// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/integrator.h"

namespace brume {

/// Stands for the volume integrator in a scene without media: nothing scatters, nothing is lost.
class ClearMedia final : public VolumeIntegrator {
 public:
  VolumeRadiance integrate(const Ray&, RenderContext&) const override { return {}; }
  Rgb transmittance(const Ray&, RenderContext&) const override { return Rgb(1.f); }
};

/// A surface and a volume integrator joined, as in PBRT-v2:
///   L = Tr Ls + Lv        Ls: the surface's radiance, or what infinite lights send where none is
/// The volume integrator is not asked when the scene has no medium.
class CameraRadiance final : public RayRadiance {
 public:
  CameraRadiance(const Scene& scene, const SurfaceIntegrator& surface,
                 const VolumeIntegrator& media)
      : scene_(scene), surface_(surface), media_(media) {}
  Rgb Li(const FootprintRay& ray, int depth, RenderContext& context) const override;

 private:
  const Scene& scene_;
  const SurfaceIntegrator& surface_;
  const VolumeIntegrator& media_;
};

}  // namespace brume
