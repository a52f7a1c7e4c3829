// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "core/bsdf.h"
#include "core/integrator.h"
#include "core/registry.h"
#include "transport/direct_light.h"
#include "transport/light_tree.h"
#include "transport/specular.h"

namespace brume {
namespace {

/// Light samples that are asked for at once; larger counts are made of several such sets.
constexpr int kSetSize = 256;

/// Direct light with multiple importance sampling of light and BSDF, and specular bounces.
///   L = Le + sum_lights Int f Li |cos| dwi + specular bounces            [W m^-2 sr^-1]
/// "all" estimates every light with its own "nsamples" (rounded as the sampler likes it); "one"
/// chooses a light by its importance. Unbiased for this partition of paths: light scattered by two
/// or more non-specular surfaces is left out. Test: surface_integrators_test.
class DirectLighting final : public SurfaceIntegrator {
 public:
  enum class Strategy { All, One };
  struct Params {
    int maxdepth = 5;
    Strategy strategy = Strategy::All;
    void visit(ParamVisitor& v) {
      v(maxdepth, "maxdepth", Range<int>{0, 256}, Unit::None,
        "longest chain of specular bounces; a ray of depth d goes on while d + 1 < maxdepth");
      v(strategy, "strategy", {{"all", Strategy::All}, {"one", Strategy::One}},
        "sample all lights at every point, or one of them, chosen by its importance there");
    }
  };
  DirectLighting(Params params, const FactoryContext& context)
      : params_(params), scene_(*context.scene), lights_(scene_) {
    for (const Light* light : lights_.lights()) {
      const int wanted = light->sampleCount();
      sampleCounts_.push_back(context.sampler ? context.sampler->roundCount(wanted) : wanted);
    }
  }

  Rgb Li(const SurfaceQuery& query, RenderContext& context) const override {
    Rgb L = emittedRadiance(query.hit);
    Bsdf bsdf;
    query.hit.material->evaluate(query.hit, bsdf);
    if (!bsdf.isSpecularOnly()) {
      const LitPoint point{scene_, query.hit, bsdf, query.media};
      L +=
          params_.strategy == Strategy::All ? sampleAll(point, context) : sampleOne(point, context);
    }
    return L + specularRadiance(query, bsdf, params_.maxdepth, context);
  }

 private:
  Rgb sampleAll(const LitPoint& point, RenderContext& context) const {
    Rgb L;
    for (std::size_t i = 0; i < sampleCounts_.size(); ++i) {
      const Light& light = *lights_.lights()[i];
      const int n = light.isDelta() ? 1 : sampleCounts_[i];
      L += n == 1 ? estimateOnce(point, light, context)
                  : estimateMany(point, light, n, context) / static_cast<float>(n);
    }
    return L;
  }

  Rgb sampleOne(const LitPoint& point, RenderContext& context) const {
    const auto choice =
        lights_.choose(PointReceiver(point.at.p, point.at.n), context.samples.get1D());
    if (!choice) return {};
    return estimateOnce(point, *choice->light, context) / choice->probability;
  }

  static Rgb estimateOnce(const LitPoint& point, const Light& light, RenderContext& context) {
    DirectSample u;
    u.light = context.samples.get2D();
    if (!light.isDelta()) {
      u.lobe = context.samples.get1D();
      u.direction = context.samples.get2D();
    }
    return estimateDirect(point, light, u, context);
  }

  /// Sum of n estimates.
  static Rgb estimateMany(const LitPoint& point, const Light& light, int n,
                          RenderContext& context) {
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

  Params params_;
  const Scene& scene_;
  LightTree lights_;
  std::vector<int> sampleCounts_;  // of lights_.lights()
};

const RegisterPlugin<SurfaceIntegrator, DirectLighting> kRegistration{
    "directlighting", Origin::PbrtV2,
    "direct light with multiple importance sampling, and specular bounces"};

}  // namespace
}  // namespace brume
