// SPDX-License-Identifier: Apache-2.0
#include "core/material.h"
#include "core/registry.h"
#include "materials/lobes_microfacet.h"

namespace brume {
namespace {

FresnelConductor conductorOfReflectance(const Rgb& reflectance) {
  const Rgb root = sqrt(min(reflectance, .999f));
  return {(Rgb(1.f) + root) / (Rgb(1.f) - root), Rgb(0.f)};
}

/// A metal that both blurs (Blinn facets, Torrance-Sparrow) and mirrors. Each of the two has the
/// conductor's Fresnel term with k = 0 and the eta that reflects Ks (Kr) at normal incidence, eta =
/// (1 + sqrt(r)) / (1 - sqrt(r)); the two add up to more than 1 for bright Ks and Kr (as PBRT-v2).
/// Test: materials_test.
class ShinyMetal final : public Material {
 public:
  struct Params {
    RgbSlot Kr{Rgb(1.f)}, Ks{Rgb(1.f)};
    FloatSlot roughness{.1f};
    std::optional<FloatSlot> bumpmap;
    void visit(ParamVisitor& v) {
      v(Kr, "Kr", kNonNegative, Unit::None,
        "mirror reflectance at normal incidence; above .999 counts as .999");
      v(Ks, "Ks", kNonNegative, Unit::None,
        "glossy reflectance at normal incidence; above .999 counts as .999");
      v(roughness, "roughness", kNonNegative, Unit::None,
        "the facets' exponent is 1 / roughness, at most 10000");
      declareBumpMap(v, bumpmap);
    }
  };

  ShinyMetal(Params params, const FactoryContext&) : params_(std::move(params)) {}

  bool hasSpecular() const override { return true; }
  bool hasNonSpecular() const override { return true; }
  int maxLobes() const override { return 2; }
  const FloatSlot* bumpMap() const override { return orNull(params_.bumpmap); }

  void addLobes(const SurfaceInteraction& at, Bsdf& bsdf) const override {
    const Rgb kr = reflectanceAt(params_.Kr, at), ks = reflectanceAt(params_.Ks, at);
    bsdf.add<MicrofacetLobe<FresnelConductor>>(
        Rgb(1.f), BlinnDistribution(exponentFromRoughness(nonNegativeAt(params_.roughness, at))),
        conductorOfReflectance(ks));
    bsdf.add<SpecularReflectionLobe<FresnelConductor>>(Rgb(1.f), conductorOfReflectance(kr));
  }

 private:
  Params params_;
};

const RegisterPlugin<Material, ShinyMetal> kRegistration{
    "shinymetal", Origin::PbrtV2, "metal with a mirror and a glossy reflection"};

}  // namespace
}  // namespace brume
