// SPDX-License-Identifier: Apache-2.0
// Direct light from every light of the scene, each with its own number of samples.
#pragma once

#include "core/sampler.h"
#include "transport/direct_light.h"

namespace brume {

/// PBRT-v2's strategy "all": for every light the mean of its "nsamples" estimates, whose number is
/// rounded as the sampler likes it.
///   L = sum_lights Int f Li |cos| dwi                                        [W m^-2 sr^-1]
/// Immutable and thread-safe.
class AllLights {
 public:
  /// `sampler` may be null: nothing is rounded then.
  AllLights(std::vector<const Light*> lights, const Sampler* sampler);

  /// Reflected radiance, specular lobes apart.
  Rgb reflected(const LitPoint& point, RenderContext& context) const;

 private:
  std::vector<const Light*> lights_;
  std::vector<int> sampleCounts_;
};

/// One estimate with the next numbers of the stream.
Rgb estimateDirect(const LitPoint& point, const Light& light, RenderContext& context);

}  // namespace brume
