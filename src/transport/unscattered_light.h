// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/integrator.h"
#include "core/medium_along_ray.h"
#include "transport/light_choice.h"
#include "transport/medium_light.h"

namespace brume {

/// Light that comes straight from the sources and is scattered once, along a stretch of a ray:
///   Int Tr(0,t) sigma_s(t) Int_S2 f_p(w', w) L_light(x_t, w') V Tr dw' dt        [W m^-2 sr^-1]
/// One light is chosen by the irradiance it sheds along the stretch, and one distance by
/// equiangular and transmittance sampling (balance heuristic). Unbiased. Glass blocks light here
/// as any surface does. Source: Kulla, Fajardo 2012.
class UnscatteredLight {
 public:
  explicit UnscatteredLight(const Scene& scene) : scene_(scene), lights_(scene.lights()) {}
  /// Tr counts from the start of the medium's range.
  Rgb estimate(const MediumAlongRay& medium, RenderContext& context) const;

 private:
  const Scene& scene_;
  LightChoice lights_;
};

}  // namespace brume
