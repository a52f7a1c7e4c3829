// SPDX-License-Identifier: Apache-2.0
#include "core/log.h"
#include "core/material.h"
#include "core/registry.h"
#include "materials/lobes_microfacet.h"

namespace brume {
namespace {

/// Everything at once, times `opacity`: Lambert Kd, Blinn facets Ks, mirror Kr and refraction Kt;
/// the rest, 1 - opacity, passes straight through. Fresnel's terms have PBRT-v2's indices, which
/// are reversed: `index` is on the side of the normal, 1 behind it. Test: materials_test.
class Uber final : public Material {
 public:
  struct Params {
    RgbSlot Kd{Rgb(.25f)}, Ks{Rgb(.25f)}, Kr{Rgb(0.f)}, Kt{Rgb(0.f)}, opacity{Rgb(1.f)};
    FloatSlot roughness{.1f}, index{1.5f};
    std::optional<FloatSlot> bumpmap;
    void visit(ParamVisitor& v) {
      v(Kd, "Kd", kNonNegative, Unit::None, "diffuse reflectance");
      v(Ks, "Ks", kNonNegative, Unit::None, "factor of the glossy reflection");
      v(Kr, "Kr", kNonNegative, Unit::None, "factor of the mirror reflection");
      v(Kt, "Kt", kNonNegative, Unit::None, "factor of the refracted light");
      v(roughness, "roughness", kNonNegative, Unit::None,
        "the facets' exponent is 1 / roughness, at most 10000");
      v(index, "index", {0.f, kMaxIndex, true}, Unit::None,
        "index of refraction, on the side of the normal");
      v(opacity, "opacity", kNonNegative, Unit::None,
        "factor of all of these; 1 - opacity passes straight through");
      declareBumpMap(v, bumpmap);
    }
  };

  Uber(Params params, const FactoryContext& context) : params_(std::move(params)) {
    if (params_.opacity.isConstant() && params_.opacity.constant.maxChannel() > 1.f)
      context.log->warning(context.where,
                           "opacity above 1: the surface reflects more than its Kd, Ks, Kr and Kt "
                           "say, and nothing passes through");
  }

  bool hasSpecular() const override {
    return isTransparent() ||
           (isSeen() && (canBeNonBlack(params_.Kr) || canBeNonBlack(params_.Kt)));
  }
  bool hasNonSpecular() const override {
    return isSeen() && (canBeNonBlack(params_.Kd) || canBeNonBlack(params_.Ks));
  }
  int maxLobes() const override { return lobeCount(); }
  const FloatSlot* bumpMap() const override { return orNull(params_.bumpmap); }

  void addLobes(const SurfaceInteraction& at, Bsdf& bsdf) const override {
    const Rgb opacity = reflectanceAt(params_.opacity, at);
    const FresnelDielectric fresnel{indexAt(params_.index, at), 1.f};
    const Rgb through = max(Rgb(1.f) - opacity, 0.f);
    if (!through.isBlack()) bsdf.add<SpecularTransmissionLobe>(through, 1.f, 1.f);
    const Rgb kd = opacity * reflectanceAt(params_.Kd, at);
    if (!kd.isBlack()) bsdf.add<LambertLobe>(kd);
    const Rgb ks = opacity * reflectanceAt(params_.Ks, at);
    if (!ks.isBlack())
      bsdf.add<MicrofacetLobe<FresnelDielectric>>(
          ks, BlinnDistribution(exponentFromRoughness(nonNegativeAt(params_.roughness, at))),
          fresnel);
    const Rgb kr = opacity * reflectanceAt(params_.Kr, at);
    if (!kr.isBlack()) bsdf.add<SpecularReflectionLobe<FresnelDielectric>>(kr, fresnel);
    const Rgb kt = opacity * reflectanceAt(params_.Kt, at);
    if (!kt.isBlack()) bsdf.add<SpecularTransmissionLobe>(kt, fresnel.etaI, fresnel.etaT);
  }

 private:
  bool isSeen() const { return canBeNonBlack(params_.opacity); }
  bool isTransparent() const {
    return !params_.opacity.isConstant() || params_.opacity.constant.minChannel() < 1.f;
  }
  int lobeCount() const {
    int n = isTransparent() ? 1 : 0;
    if (!isSeen()) return n;
    for (const RgbSlot* slot : {&params_.Kd, &params_.Ks, &params_.Kr, &params_.Kt})
      n += canBeNonBlack(*slot) ? 1 : 0;
    return n;
  }

  Params params_;
};

const RegisterPlugin<Material, Uber> kRegistration{
    "uber", Origin::PbrtV2, "diffuse, glossy, mirror, refraction and opacity at once"};

}  // namespace
}  // namespace brume
