// SPDX-License-Identifier: Apache-2.0
#include "core/integrator.h"
#include "core/log.h"
#include "core/medium_along_ray.h"
#include "core/registry.h"

namespace brume {

namespace {

/// Emission and absorption along the ray, no in-scattering.
///   Lv = Int Tr(0,t) Le(t) dt,  Tr(0,t) = exp(-Int_0^t sigma_t)        [W m^-2 sr^-1]
/// Exact: one closed form per volume, Gauss-Legendre below 1e-9 where emitting volumes overlap
/// others. No random numbers, no step. Source: PBRT-v2 for the plugin. Test: emission_test.
class Emission final : public VolumeIntegrator {
 public:
  struct Params {
    std::optional<float> stepsize;
    void visit(ParamVisitor& v) {
      v(stepsize, "stepsize", kPositive, Unit::Length,
        "has no effect: emission and transmittance are integrated exactly");
    }
  };

  Emission(const Params& params, const FactoryContext& context) : volume_(context.scene->volume()) {
    if (params.stepsize && context.log)
      context.log->verbose(
          "emission: \"stepsize\" has no effect, emission and transmittance are exact");
  }

  VolumeRadiance integrate(const Ray& ray, RenderContext& context) const override {
    if (!volume_) return {};
    const auto range = volume_->intersect(ray);
    if (!range) return {};
    context.stats.add(Stat::VolumeSegments);
    VolumeRadiance result;
    if (volume_->isEmissive())
      result.Lv = context.stats.checkRadiance(volume_->emission(ray, *range));
    result.Tr = volume_->transmittance(ray, *range);
    return result;
  }

  Rgb transmittance(const Ray& ray, RenderContext&) const override {
    return volume_ ? volume_->transmittance(ray) : Rgb(1.f);
  }

 private:
  const Volume* volume_;
};

const RegisterPlugin<VolumeIntegrator, Emission> kRegistration{
    "emission", Origin::PbrtV2, "emission and absorption of media, exact"};

}  // namespace

}  // namespace brume
