// SPDX-License-Identifier: Apache-2.0
// The image loop of integrators that answer per pass.
#pragma once

#include "core/integrator.h"
#include "renderers/image_renderer.h"

namespace brume {

/// Runs a PassGlobalIntegrator: one pass is one sample of every pixel.
class PassRenderer final : public ImageRenderer {
 public:
  struct Parts {
    const Camera& camera;
    const Sampler& sampler;
    Film& film;
    PassGlobalIntegrator& integrator;
    std::uint64_t seed = 0;
    bool footprints = true;
    Log& log;
  };
  explicit PassRenderer(const Parts& parts) : parts_(parts) {}

  bool render(SampleRange range, const std::atomic<bool>& stop, Stats& stats,
              const std::function<void(double share, const Stats& stats)>& onShare) override;
  double squaredBlur() const override { return parts_.integrator.squaredBlur(); }

 private:
  Parts parts_;
};

}  // namespace brume
