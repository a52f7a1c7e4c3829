// SPDX-License-Identifier: Apache-2.0
#include "core/material.h"
#include "core/registry.h"
#include "materials/lobes.h"

namespace brume {
namespace {

/// A diffuse surface, the same on both sides: Lambert, f = Kd / pi, or Oren-Nayar for sigma > 0
/// (see OrenNayarLobe). Source: Oren, Nayar 1994. Test: materials_test.
class Matte final : public Material {
 public:
  struct Params {
    RgbSlot Kd{Rgb(.5f)};
    FloatSlot sigma{0.f};
    std::optional<FloatSlot> bumpmap;
    void visit(ParamVisitor& v) {
      v(Kd, "Kd", kNonNegative, Unit::None, "diffuse reflectance");
      v(sigma, "sigma", {0.f, 90.f}, Unit::Degrees,
        "standard deviation of the facets' slope; textures are clamped to 0..90");
      declareBumpMap(v, bumpmap);
    }
  };

  Matte(Params params, const FactoryContext&) : params_(std::move(params)) {}

  bool hasSpecular() const override { return false; }
  bool hasNonSpecular() const override { return canBeNonBlack(params_.Kd); }
  int maxLobes() const override { return 1; }
  const FloatSlot* bumpMap() const override { return orNull(params_.bumpmap); }

  void addLobes(const SurfaceInteraction& at, Bsdf& bsdf) const override {
    const Rgb kd = reflectanceAt(params_.Kd, at);
    if (kd.isBlack()) return;
    const float sigma = std::min(nonNegativeAt(params_.sigma, at), 90.f);
    if (sigma == 0.f)
      bsdf.add<LambertLobe>(kd);
    else
      bsdf.add<OrenNayarLobe>(kd, sigma);
  }

 private:
  Params params_;
};

const RegisterPlugin<Material, Matte> kRegistration{"matte", Origin::PbrtV2,
                                                    "diffuse surface, smooth or rough"};

}  // namespace
}  // namespace brume
