// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <bit>

#include "core/integrator.h"
#include "core/registry.h"
#include "core/sampling.h"

namespace brume {
namespace {

/// Directions that are asked for at once.
constexpr int kSetSize = 256;

/// The unblocked share of the hemisphere above the surface, uniform in solid angle (not weighted
/// by the cosine), the same in all channels.
///   L = 1/(2 pi) Int V(p, w; maxdist) dw
/// Lights and materials play no part. Unbiased. Test: surface_integrators_test.
class AmbientOcclusion final : public SurfaceIntegrator {
 public:
  struct Params {
    int nsamples = 2048;
    std::optional<float> maxdist;
    void visit(ParamVisitor& v) {
      v(nsamples, "nsamples", Range<int>{1, 1 << 24}, Unit::Samples,
        "directions per surface point, rounded up to a power of two");
      v(maxdist, "maxdist", kPositive, Unit::Length,
        "surfaces beyond this distance do not block; by default all do");
    }
  };
  AmbientOcclusion(Params params, const FactoryContext& context)
      : params_(params), scene_(*context.scene) {
    // --quick asks for a quarter of the samples, as in PBRT-v2.
    const int wanted = std::max(1, context.quick ? params_.nsamples / 4 : params_.nsamples);
    count_ = static_cast<int>(std::bit_ceil(static_cast<unsigned>(wanted)));
  }

  Rgb Li(const SurfaceQuery& query, RenderContext& context) const override {
    const SurfaceInteraction& at = query.hit;
    const Frame frame = Frame::fromZ(faceForward(at.n, at.wo));
    const float reach = params_.maxdist.value_or(kInfinity);
    std::array<Vec2, kSetSize> u;
    int clear = 0;
    for (int begin = 0; begin < count_; begin += kSetSize) {
      const auto set =
          std::span(u).first(static_cast<std::size_t>(std::min(kSetSize, count_ - begin)));
      context.samples.get2DArray(set);
      for (const Vec2& ui : set) {
        const Vec3 w = frame.fromLocal(sampleUniformHemisphere(ui));
        if (!scene_.isOccluded(at.spawnRay(w, reach), context.stats)) ++clear;
      }
    }
    return Rgb(static_cast<float>(clear) / static_cast<float>(count_));
  }

 private:
  Params params_;
  const Scene& scene_;
  int count_ = 1;
};

const RegisterPlugin<SurfaceIntegrator, AmbientOcclusion> kRegistration{
    "ambientocclusion", Origin::PbrtV2, "unblocked share of the hemisphere above each point"};

}  // namespace
}  // namespace brume
