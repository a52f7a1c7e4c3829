// SPDX-License-Identifier: Apache-2.0
#include "renderers/pass_renderer.h"

namespace brume {

bool PassRenderer::render(SampleRange range, const std::atomic<bool>& stop, Stats& stats,
                          const std::function<void(double, const Stats&)>& onShare) {
  const auto count = static_cast<double>(range.count());
  for (std::int64_t pass = range.first; pass < range.end; ++pass) {
    const PassContext context{parts_.camera,     parts_.sampler, parts_.film, parts_.seed, pass,
                              parts_.footprints, stop,           stats,       parts_.log};
    const auto done = static_cast<double>(pass - range.first);
    if (!parts_.integrator.renderPass(
            context, [&](double share) { onShare((done + share) / count, stats); }))
      return false;
    onShare((done + 1) / count, stats);
  }
  return true;
}

}  // namespace brume
