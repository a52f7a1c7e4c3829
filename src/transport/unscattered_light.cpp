// SPDX-License-Identifier: Apache-2.0
#include "transport/unscattered_light.h"

#include "transport/distance_sampling.h"

namespace brume {

Rgb UnscatteredLight::estimate(const MediumAlongRay& medium, RenderContext& context) const {
  // The same number of dimensions is taken whatever the ray meets.
  const float uChoice = context.samples.get1D(), uDistance = context.samples.get1D();
  MediumLightUniforms u;
  u.light = context.samples.get2D();
  u.technique = context.samples.get1D();
  u.lobe = context.samples.get1D();
  u.phase = context.samples.get2D();
  if (medium.isEmpty()) return {};

  thread_local LightChoice::Choices choices;
  lights_.along(medium.ray(), medium.range(), choices);
  if (choices.isEmpty()) return {};
  const auto& chosen = choices.choose(uChoice);
  const ScatteringDistanceSampler distances(medium, chosen.illuminated, chosen.light->position());
  if (distances.isEmpty()) return {};
  const auto at = distances.sample(uDistance);
  if (!at || at->medium.sigma_s.isBlack()) return {};
  context.stats.add(Stat::VolumeSamples);
  const Ray& ray = medium.ray();
  return estimateInscattering(scene_, {ray(at->t), -ray.d, ray.time}, *chosen.light, u,
                              context.stats) *
         at->medium.sigma_s * at->Tr / (at->pdf * chosen.probability);
}

}  // namespace brume
