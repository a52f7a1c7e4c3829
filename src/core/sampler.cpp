// SPDX-License-Identifier: Apache-2.0
#include "core/sampler.h"

#include <fmt/format.h>

namespace brume {

int Sampler::countFor(const FactoryContext& context, int fromScene, int quick) {
  if (!context.samplesPerPixel) return context.quick ? quick : fromScene;
  const int n = *context.samplesPerPixel;
  if (!kPixelSamplesRange.contains(n))
    throw SceneError(fmt::format("--spp {}: it must lie between {} and {}", n,
                                 kPixelSamplesRange.lo, kPixelSamplesRange.hi));
  return n;
}

}  // namespace brume
