// SPDX-License-Identifier: Apache-2.0
#include "core/material.h"
#include "core/registry.h"
#include "materials/lobes.h"

namespace brume {
namespace {

/// A perfect mirror of reflectance Kr, without Fresnel's term. Test: materials_test.
class Mirror final : public Material {
 public:
  struct Params {
    RgbSlot Kr{Rgb(.9f)};
    std::optional<FloatSlot> bumpmap;
    void visit(ParamVisitor& v) {
      v(Kr, "Kr", kNonNegative, Unit::None, "reflectance");
      declareBumpMap(v, bumpmap);
    }
  };

  Mirror(Params params, const FactoryContext&) : params_(std::move(params)) {}

  bool hasSpecular() const override { return canBeNonBlack(params_.Kr); }
  bool hasNonSpecular() const override { return false; }
  int maxLobes() const override { return 1; }
  const FloatSlot* bumpMap() const override { return orNull(params_.bumpmap); }

  void addLobes(const SurfaceInteraction& at, Bsdf& bsdf) const override {
    const Rgb kr = reflectanceAt(params_.Kr, at);
    if (!kr.isBlack()) bsdf.add<SpecularReflectionLobe<FresnelNone>>(kr, FresnelNone{});
  }

 private:
  Params params_;
};

const RegisterPlugin<Material, Mirror> kRegistration{"mirror", Origin::PbrtV2, "perfect mirror"};

}  // namespace
}  // namespace brume
