// SPDX-License-Identifier: Apache-2.0
#include "core/material.h"
#include "core/registry.h"
#include "materials/lobes_microfacet.h"

namespace brume {
namespace {

/// A diffuse base under a glossy coat whose facets may differ in u and v (brushed): see
/// FresnelBlendLobe, exponents 1 / roughness along u and v. Source: Ashikhmin, Shirley 2000. Test:
/// materials_test.
class Substrate final : public Material {
 public:
  struct Params {
    RgbSlot Kd{Rgb(.5f)}, Ks{Rgb(.5f)};
    FloatSlot uroughness{.1f}, vroughness{.1f};
    std::optional<FloatSlot> bumpmap;
    void visit(ParamVisitor& v) {
      v(Kd, "Kd", kNonNegative, Unit::None, "diffuse reflectance");
      v(Ks, "Ks", kNonNegative, Unit::None, "glossy reflectance at normal incidence");
      v(uroughness, "uroughness", kNonNegative, Unit::None,
        "the facets' exponent along u is 1 / uroughness, at most 10000");
      v(vroughness, "vroughness", kNonNegative, Unit::None,
        "the facets' exponent along v is 1 / vroughness, at most 10000");
      declareBumpMap(v, bumpmap);
    }
  };

  Substrate(Params params, const FactoryContext&) : params_(std::move(params)) {}

  bool hasSpecular() const override { return false; }
  bool hasNonSpecular() const override { return true; }
  int maxLobes() const override { return 1; }
  const FloatSlot* bumpMap() const override { return orNull(params_.bumpmap); }
  bool usesTangents() const override {
    const FloatSlot &u = params_.uroughness, &v = params_.vroughness;
    const bool isIsotropic = u.isConstant() && v.isConstant() && u.constant == v.constant;
    return bumpMap() || !isIsotropic;
  }

  void addLobes(const SurfaceInteraction& at, Bsdf& bsdf) const override {
    const AnisotropicDistribution facets(
        exponentFromRoughness(nonNegativeAt(params_.uroughness, at)),
        exponentFromRoughness(nonNegativeAt(params_.vroughness, at)));
    bsdf.add<FresnelBlendLobe>(reflectanceAt(params_.Kd, at), reflectanceAt(params_.Ks, at),
                               facets);
  }

 private:
  Params params_;
};

const RegisterPlugin<Material, Substrate> kRegistration{
    "substrate", Origin::PbrtV2, "diffuse base under a glossy, possibly brushed coat"};

}  // namespace
}  // namespace brume
