// SPDX-License-Identifier: Apache-2.0
#include "core/material.h"
#include "core/registry.h"
#include "core/spectrum.h"
#include "materials/lobes_microfacet.h"

namespace brume {
namespace {

// Copper: wavelengths [nm], eta and k as tabulated in PBRT-v2.
constexpr float kCopperWavelengths[] = {
    298.7570554f, 302.4004341f, 306.1337728f, 309.960445f,  313.8839949f, 317.9081487f,
    322.036826f,  326.2741526f, 330.6244747f, 335.092373f,  339.6826795f, 344.4004944f,
    349.2512056f, 354.2405086f, 359.374429f,  364.6593471f, 370.1020239f, 375.7096303f,
    381.4897785f, 387.4505563f, 393.6005651f, 399.9489613f, 406.5055016f, 413.2805933f,
    420.2853492f, 427.5316483f, 435.0322035f, 442.8006357f, 450.8515564f, 459.2006593f,
    467.8648226f, 476.8622231f, 486.2124627f, 495.936712f,  506.0578694f, 516.6007417f,
    527.5922468f, 539.0616435f, 551.0407911f, 563.5644455f, 576.6705953f, 590.4008476f,
    604.8008683f, 619.92089f,   635.8162974f, 652.5483053f, 670.1847459f, 688.8009889f,
    708.4810171f, 729.3186941f, 751.4192606f, 774.9011125f, 799.8979226f, 826.5611867f,
    855.0632966f, 885.6012714f};
constexpr float kCopperEta[] = {
    1.400313f, 1.38f,  1.358438f, 1.34f,  1.329063f, 1.325f, 1.3325f,   1.34f,  1.334375f, 1.325f,
    1.317812f, 1.31f,  1.300313f, 1.29f,  1.281563f, 1.27f,  1.249062f, 1.225f, 1.2f,      1.18f,
    1.174375f, 1.175f, 1.1775f,   1.18f,  1.178125f, 1.175f, 1.172812f, 1.17f,  1.165312f, 1.16f,
    1.155312f, 1.15f,  1.142812f, 1.135f, 1.131562f, 1.12f,  1.092437f, 1.04f,  .950375f,  .826f,
    .645875f,  .468f,  .35125f,   .272f,  .230813f,  .214f,  .20925f,   .213f,  .21625f,   .223f,
    .2365f,    .25f,   .254188f,  .26f,   .28f,      .3f};
constexpr float kCopperK[] = {
    1.662125f, 1.687f, 1.703313f, 1.72f,  1.744563f, 1.77f,  1.791625f, 1.81f,  1.822125f, 1.834f,
    1.85175f,  1.872f, 1.89425f,  1.916f, 1.931688f, 1.95f,  1.972438f, 2.015f, 2.121562f, 2.21f,
    2.177188f, 2.13f,  2.160063f, 2.21f,  2.249938f, 2.289f, 2.326f,    2.362f, 2.397625f, 2.433f,
    2.469187f, 2.504f, 2.535875f, 2.564f, 2.589625f, 2.605f, 2.595562f, 2.583f, 2.5765f,   2.599f,
    2.678062f, 2.809f, 3.01075f,  3.24f,  3.458187f, 3.67f,  3.863125f, 4.05f,  4.239563f, 4.43f,
    4.619563f, 4.817f, 5.034125f, 5.26f,  5.485625f, 5.717f};

/// A metal of Blinn's facets (exponent 1 / roughness, at most 10000) with the conductor's Fresnel
/// term of index eta and absorption k; copper by default. There is no mirror part: roughness 0
/// gives the sharpest facets. Source: Torrance, Sparrow 1967. Test: materials_test.
class Metal final : public Material {
 public:
  struct Params {
    RgbSlot eta{rgbFromSamples(kCopperWavelengths, kCopperEta)};
    RgbSlot k{rgbFromSamples(kCopperWavelengths, kCopperK)};
    FloatSlot roughness{.01f};
    std::optional<FloatSlot> bumpmap;
    void visit(ParamVisitor& v) {
      v(eta, "eta", {0.f, kMaxIndex}, Unit::None, "index of refraction; copper by default");
      v(k, "k", {0.f, kMaxIndex}, Unit::None, "absorption coefficient; copper by default");
      v(roughness, "roughness", kNonNegative, Unit::None,
        "the facets' exponent is 1 / roughness, at most 10000");
      declareBumpMap(v, bumpmap);
    }
  };

  Metal(Params params, const FactoryContext&) : params_(std::move(params)) {}

  bool hasSpecular() const override { return false; }
  bool hasNonSpecular() const override { return true; }
  int maxLobes() const override { return 1; }
  const FloatSlot* bumpMap() const override { return orNull(params_.bumpmap); }

  void addLobes(const SurfaceInteraction& at, Bsdf& bsdf) const override {
    bsdf.add<MicrofacetLobe<FresnelConductor>>(
        Rgb(1.f), BlinnDistribution(exponentFromRoughness(nonNegativeAt(params_.roughness, at))),
        FresnelConductor{indexAt(params_.eta, at), indexAt(params_.k, at)});
  }

 private:
  Params params_;
};

const RegisterPlugin<Material, Metal> kRegistration{"metal", Origin::PbrtV2, "rough metal"};

}  // namespace
}  // namespace brume
