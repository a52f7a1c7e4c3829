// SPDX-License-Identifier: Apache-2.0
#include "core/bsdf.h"
#include "core/integrator.h"
#include "core/registry.h"
#include "transport/all_lights.h"
#include "transport/direct_light.h"
#include "transport/light_tree.h"
#include "transport/specular.h"

namespace brume {
namespace {

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
      : params_(params),
        scene_(*context.scene),
        lights_(scene_),
        all_(lights_.lights(), context.sampler) {}

  Rgb Li(const SurfaceQuery& query, RenderContext& context) const override {
    Rgb L = emittedRadiance(query.hit);
    Bsdf bsdf;
    query.hit.material->evaluate(query.hit, bsdf);
    if (!bsdf.isSpecularOnly()) {
      const LitPoint point{scene_, query.hit, bsdf, query.media};
      L += params_.strategy == Strategy::All ? all_.reflected(point, context)
                                             : sampleOne(point, context);
    }
    return L + specularRadiance(query, bsdf, params_.maxdepth, context);
  }

 private:
  Rgb sampleOne(const LitPoint& point, RenderContext& context) const {
    const auto choice =
        lights_.choose(PointReceiver(point.at.p, point.at.n), context.samples.get1D());
    if (!choice) return {};
    return estimateDirect(point, *choice->light, context) / choice->probability;
  }

  Params params_;
  const Scene& scene_;
  LightTree lights_;
  AllLights all_;
};

const RegisterPlugin<SurfaceIntegrator, DirectLighting> kRegistration{
    "directlighting", Origin::PbrtV2,
    "direct light with multiple importance sampling, and specular bounces"};

}  // namespace
}  // namespace brume
