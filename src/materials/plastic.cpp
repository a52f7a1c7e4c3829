// SPDX-License-Identifier: Apache-2.0
#include "core/material.h"
#include "core/registry.h"
#include "materials/lobes_microfacet.h"

namespace brume {
namespace {

/// A diffuse base and a glossy coat: Kd / pi + Torrance-Sparrow with Blinn's facets of exponent
/// 1 / roughness (at most 10000). Fresnel's term has PBRT-v2's indices, which are reversed (1.5
/// over 1): beyond a half angle of 41.8 degrees the coat reflects all of Ks. Source: Torrance,
/// Sparrow 1967; Blinn 1977. Test: materials_test.
class Plastic final : public Material {
 public:
  struct Params {
    RgbSlot Kd{Rgb(.25f)}, Ks{Rgb(.25f)};
    FloatSlot roughness{.1f};
    std::optional<FloatSlot> bumpmap;
    void visit(ParamVisitor& v) {
      v(Kd, "Kd", kNonNegative, Unit::None, "diffuse reflectance");
      v(Ks, "Ks", kNonNegative, Unit::None, "factor of the glossy reflection");
      v(roughness, "roughness", kNonNegative, Unit::None,
        "the facets' exponent is 1 / roughness, at most 10000");
      declareBumpMap(v, bumpmap);
    }
  };

  Plastic(Params params, const FactoryContext&) : params_(std::move(params)) {}

  bool hasSpecular() const override { return false; }
  bool hasNonSpecular() const override {
    return canBeNonBlack(params_.Kd) || canBeNonBlack(params_.Ks);
  }
  int maxLobes() const override { return 2; }
  const FloatSlot* bumpMap() const override { return orNull(params_.bumpmap); }

  void addLobes(const SurfaceInteraction& at, Bsdf& bsdf) const override {
    const Rgb kd = reflectanceAt(params_.Kd, at), ks = reflectanceAt(params_.Ks, at);
    if (!kd.isBlack()) bsdf.add<LambertLobe>(kd);
    if (!ks.isBlack())
      bsdf.add<MicrofacetLobe<FresnelDielectric>>(
          ks, BlinnDistribution(exponentFromRoughness(nonNegativeAt(params_.roughness, at))),
          FresnelDielectric{1.5f, 1.f});
  }

 private:
  Params params_;
};

const RegisterPlugin<Material, Plastic> kRegistration{"plastic", Origin::PbrtV2,
                                                      "diffuse base with a glossy coat"};

}  // namespace
}  // namespace brume
