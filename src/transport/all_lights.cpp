// SPDX-License-Identifier: Apache-2.0
#include "transport/all_lights.h"

#include <array>

namespace brume {
namespace {

/// Light samples that are asked for at once; larger counts are made of several such sets.
constexpr int kSetSize = 256;

/// Sum of n estimates.
Rgb estimateMany(const LitPoint& point, const Light& light, int n, RenderContext& context) {
  Rgb sum;
  std::array<Vec2, kSetSize> uLight, uDirection;
  std::array<float, kSetSize> uLobe;
  for (int begin = 0; begin < n; begin += kSetSize) {
    const auto count = static_cast<std::size_t>(std::min(kSetSize, n - begin));
    context.samples.get2DArray(std::span(uLight).first(count));
    context.samples.get1DArray(std::span(uLobe).first(count));
    context.samples.get2DArray(std::span(uDirection).first(count));
    for (std::size_t i = 0; i < count; ++i)
      sum += estimateDirect(point, light, {uLight[i], uLobe[i], uDirection[i]}, context);
  }
  return sum;
}

}  // namespace

AllLights::AllLights(std::vector<const Light*> lights, const Sampler* sampler)
    : lights_(std::move(lights)) {
  for (const Light* light : lights_) {
    const int wanted = light->isDelta() ? 1 : light->sampleCount();
    sampleCounts_.push_back(sampler && !light->isDelta() ? sampler->roundCount(wanted) : wanted);
  }
}

Rgb AllLights::reflected(const LitPoint& point, RenderContext& context) const {
  Rgb L;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const int n = sampleCounts_[i];
    L += n == 1 ? estimateDirect(point, *lights_[i], context)
                : estimateMany(point, *lights_[i], n, context) / static_cast<float>(n);
  }
  return L;
}

Rgb estimateDirect(const LitPoint& point, const Light& light, RenderContext& context) {
  DirectSample u;
  u.light = context.samples.get2D();
  if (!light.isDelta()) {
    u.lobe = context.samples.get1D();
    u.direction = context.samples.get2D();
  }
  return estimateDirect(point, light, u, context);
}

}  // namespace brume
