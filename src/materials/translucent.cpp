// SPDX-License-Identifier: Apache-2.0
#include "core/material.h"
#include "core/registry.h"
#include "materials/lobes_microfacet.h"

namespace brume {
namespace {

/// Plastic on both sides: each lobe of plastic (with Kd and Ks) appears once times `reflect`, and
/// once turned to the other side times `transmit`. Nothing is refracted, and nothing keeps reflect
/// + transmit below 1 (as PBRT-v2). Test: materials_test.
class Translucent final : public Material {
 public:
  struct Params {
    RgbSlot Kd{Rgb(.25f)}, Ks{Rgb(.25f)}, reflect{Rgb(.5f)}, transmit{Rgb(.5f)};
    FloatSlot roughness{.1f};
    std::optional<FloatSlot> bumpmap;
    void visit(ParamVisitor& v) {
      v(Kd, "Kd", kNonNegative, Unit::None, "factor of diffuse light on both sides");
      v(Ks, "Ks", kNonNegative, Unit::None, "factor of glossy light on both sides");
      v(reflect, "reflect", kNonNegative, Unit::None, "fraction that is reflected");
      v(transmit, "transmit", kNonNegative, Unit::None, "fraction that is transmitted");
      v(roughness, "roughness", kNonNegative, Unit::None,
        "the facets' exponent is 1 / roughness, at most 10000");
      declareBumpMap(v, bumpmap);
    }
  };

  Translucent(Params params, const FactoryContext&) : params_(std::move(params)) {}

  bool hasSpecular() const override { return false; }
  bool hasNonSpecular() const override {
    return (canBeNonBlack(params_.Kd) || canBeNonBlack(params_.Ks)) &&
           (canBeNonBlack(params_.reflect) || canBeNonBlack(params_.transmit));
  }
  int maxLobes() const override { return 4; }
  const FloatSlot* bumpMap() const override { return orNull(params_.bumpmap); }

  void addLobes(const SurfaceInteraction& at, Bsdf& bsdf) const override {
    using Lambert = LambertLobe;
    using Glossy = MicrofacetLobe<FresnelDielectric>;
    const Rgb r = reflectanceAt(params_.reflect, at), t = reflectanceAt(params_.transmit, at);
    const Rgb kd = reflectanceAt(params_.Kd, at), ks = reflectanceAt(params_.Ks, at);
    const Rgb rd = r * kd, td = t * kd, rs = r * ks, ts = t * ks;
    const BlinnDistribution facets(exponentFromRoughness(nonNegativeAt(params_.roughness, at)));
    const FresnelDielectric fresnel{1.5f, 1.f};  // reversed, as in plastic
    if (!rd.isBlack()) bsdf.add<Lambert>(rd);
    if (!td.isBlack()) bsdf.add<MirroredLobe<Lambert>>(Lambert(td));
    if (!rs.isBlack()) bsdf.add<Glossy>(rs, facets, fresnel);
    if (!ts.isBlack()) bsdf.add<MirroredLobe<Glossy>>(Glossy(ts, facets, fresnel));
  }

 private:
  Params params_;
};

const RegisterPlugin<Material, Translucent> kRegistration{"translucent", Origin::PbrtV2,
                                                          "plastic that also lets light through"};

}  // namespace
}  // namespace brume
