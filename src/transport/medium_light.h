// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/scene.h"

namespace brume {

/// A point in a medium at which light is turned towards wo.
struct MediumVertex {
  Vec3 p{0};
  Vec3 wo{0};  ///< unit, to the viewer
  float time = 0;
  Rgb carried{1.f};  ///< what the estimate will be multiplied by, up to a factor: guides sampling
};

/// Random numbers for one estimate.
struct MediumLightUniforms {
  Vec2 light{0};
  float technique = 0;  ///< light or phase sampling
  float lobe = 0;       ///< of the phase function
  Vec2 phase{0};
};

/// Whether phase function sampling pays: its peak rises this far above isotropic.
bool wantsPhaseSampling(const Volume& volume, const Light& light);

/// One-sample estimate of the light that a vertex turns towards the viewer, per sigma_s:
///   Int_S2 p(wo, wi) L_light(wi) V Tr dwi                              [W m^-2 sr^-1]
/// Tr is exact, up to the light. Surfaces of any kind block, glass too (PBRT-v2). For lights that
/// are no delta distributions in media with a peaked phase function, a share q of the samples
/// follows the phase function, more the wider the light looks from there and the nearer it lies to
/// the lobe: with p the phase function's largest value towards a ball that holds the light, seen
/// under the solid angle Omega,
///   q = min(p / (p + 1 / Omega), 0.5), 0 below 0.05;    0.5 where Omega > 2 pi
/// infinite lights: q = clamp(peak / (peak + pdf_light(middle)), 0.05, 0.5). The density is that of
/// the mixture (balance heuristic).
Rgb estimateInscattering(const Scene& scene, const MediumVertex& vertex, const Light& light,
                         const MediumLightUniforms& u, Stats& stats);

}  // namespace brume
