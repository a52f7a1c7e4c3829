// SPDX-License-Identifier: Apache-2.0
#include "core/bsdf.h"
#include "core/integrator.h"
#include "core/registry.h"
#include "transport/direct_light.h"
#include "transport/light_tree.h"
#include "transport/specular.h"

namespace brume {
namespace {

/// Direct light by one sample of every light, without multiple importance sampling, and specular
/// bounces (Whitted 1980).
///   L = Le + sum_lights f L |cos| / pdf + specular bounces               [W m^-2 sr^-1]
/// Unbiased for direct light and specular chains up to maxdepth; light scattered by two or more
/// non-specular surfaces is left out. Test: surface_integrators_test.
class Whitted final : public SurfaceIntegrator {
 public:
  struct Params {
    int maxdepth = 5;
    void visit(ParamVisitor& v) {
      v(maxdepth, "maxdepth", Range<int>{0, 256}, Unit::None,
        "longest chain of specular bounces; a ray of depth d goes on while d + 1 < maxdepth");
    }
  };
  Whitted(Params params, const FactoryContext& context)
      : params_(params), scene_(*context.scene), lights_(emittingLights(scene_)) {}

  Rgb Li(const SurfaceQuery& query, RenderContext& context) const override {
    Rgb L = emittedRadiance(query.hit);
    Bsdf bsdf;
    query.hit.material->evaluate(query.hit, bsdf);
    const LitPoint point{scene_, query.hit, bsdf, query.media};
    for (const Light* light : lights_)
      L += sampleLight(point, *light, context.samples.get2D(), kAllLobes, context).value;
    return L + specularRadiance(query, bsdf, params_.maxdepth, context);
  }

 private:
  Params params_;
  const Scene& scene_;
  std::vector<const Light*> lights_;
};

const RegisterPlugin<SurfaceIntegrator, Whitted> kRegistration{
    "whitted", Origin::PbrtV2, "direct light by light samples alone, and specular bounces"};

}  // namespace
}  // namespace brume
