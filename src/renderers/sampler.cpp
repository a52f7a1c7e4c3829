// SPDX-License-Identifier: Apache-2.0
#include "core/compatibility.h"
#include "core/log.h"
#include "core/registry.h"

namespace brume {
namespace {

/// PBRT-v2's default renderer: camera rays by the Sampler, radiance by the integrators. See
/// tile_renderer.h. Test: render_job_test.
class SamplerRenderer final : public RendererChoice {
 public:
  struct Params {
    bool visualizeobjectids = false;
    void visit(ParamVisitor& v) {
      v(visualizeobjectids, "visualizeobjectids",
        "accepted with a warning: the image itself is rendered");
    }
  };
  SamplerRenderer(const Params& params, const FactoryContext& context) {
    if (params.visualizeobjectids)
      context.log->warning(context.where,
                           "\"visualizeobjectids\" has no effect: the image itself is rendered");
  }
};

const RegisterPlugin<RendererChoice, SamplerRenderer> kRegistration{
    "sampler", Origin::PbrtV2, "camera rays by the Sampler, radiance by the integrators"};

}  // namespace
}  // namespace brume
