// SPDX-License-Identifier: Apache-2.0
// Light that reaches a surface without bouncing off another one.
#pragma once

#include "core/bsdf.h"
#include "core/integrator.h"

namespace brume {

/// A surface point that is to be lit, render space.
struct LitPoint {
  const Scene& scene;
  const SurfaceInteraction& at;
  const Bsdf& bsdf;
  const VolumeIntegrator& media;
};

/// Radiance that a surface emits towards wo by itself: its area light, black without one.
inline Rgb emittedRadiance(const SurfaceInteraction& at) {
  return at.areaLight ? at.areaLight->L(at.p, at.n, at.uv, at.wo) : Rgb();
}
/// Sum of what the infinite lights send along a ray that leaves the scene.
Rgb escapedRadiance(const Scene& scene, const Ray& ray);

/// f L |cos| / pdf of one light sample that is not blocked, and the two densities per solid angle
/// that a weight needs. The BSDF's density counts its `lobes`; it is 0 for delta lights, which
/// nothing else can find.
struct LitSample {
  Rgb value;
  float lightPdf = 0, bsdfPdf = 0;
};
LitSample sampleLight(const LitPoint& point, const Light& light, Vec2 u, LobeFlags lobes,
                      RenderContext& context);

/// Random numbers of one estimate of one light.
struct DirectSample {
  Vec2 light{0};
  float lobe = 0;
  Vec2 direction{0};
};
/// Reflected radiance due to one light, specular lobes apart: one sample of the light and, where it
/// can be hit, one of the BSDF, weighted by the power heuristic.
///   L = Int f(wo, wi) Li(wi) |cos| dwi                                       [W m^-2 sr^-1]
/// Source: Veach 1997, 9.2.4.
Rgb estimateDirect(const LitPoint& point, const Light& light, const DirectSample& u,
                   RenderContext& context);

}  // namespace brume
