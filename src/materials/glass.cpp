// SPDX-License-Identifier: Apache-2.0
#include "core/material.h"
#include "core/registry.h"
#include "materials/lobes.h"

namespace brume {
namespace {

/// A smooth dielectric of the given index in a medium of index 1 (the side of the normal): reflects
/// Kr F, refracts Kt (1 - F), F by Fresnel. As in PBRT-v2 radiance is not scaled by the squared
/// ratio of the indices. Test: materials_test.
class Glass final : public Material {
 public:
  struct Params {
    RgbSlot Kr{Rgb(1.f)}, Kt{Rgb(1.f)};
    FloatSlot index{1.5f};
    std::optional<FloatSlot> bumpmap;
    void visit(ParamVisitor& v) {
      v(Kr, "Kr", kNonNegative, Unit::None, "factor of the reflected light");
      v(Kt, "Kt", kNonNegative, Unit::None, "factor of the transmitted light");
      v(index, "index", {0.f, kMaxIndex, true}, Unit::None, "index of refraction of the inside");
      declareBumpMap(v, bumpmap);
    }
  };

  Glass(Params params, const FactoryContext&) : params_(std::move(params)) {}

  bool hasSpecular() const override {
    return canBeNonBlack(params_.Kr) || canBeNonBlack(params_.Kt);
  }
  bool hasNonSpecular() const override { return false; }
  int maxLobes() const override { return 2; }
  const FloatSlot* bumpMap() const override { return orNull(params_.bumpmap); }

  void addLobes(const SurfaceInteraction& at, Bsdf& bsdf) const override {
    const float index = indexAt(params_.index, at);
    const Rgb kr = reflectanceAt(params_.Kr, at), kt = reflectanceAt(params_.Kt, at);
    if (!kr.isBlack())
      bsdf.add<SpecularReflectionLobe<FresnelDielectric>>(kr, FresnelDielectric{1.f, index});
    if (!kt.isBlack()) bsdf.add<SpecularTransmissionLobe>(kt, 1.f, index);
  }

 private:
  Params params_;
};

const RegisterPlugin<Material, Glass> kRegistration{"glass", Origin::PbrtV2,
                                                    "smooth dielectric: glass, water"};

}  // namespace
}  // namespace brume
