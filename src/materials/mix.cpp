// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/log.h"
#include "core/material.h"
#include "core/registry.h"
#include "materials/lobes.h"

namespace brume {
namespace {

/// Two named materials at once: all lobes of the first times `amount`, of the second times 1 -
/// amount (0 where amount is above 1). Both are seen in the shading frame of the first, bump map
/// included (as PBRT-v2). Test: materials_test.
class Mix final : public Material {
 public:
  struct Params {
    RgbSlot amount{Rgb(.5f)};
    std::string namedmaterial1, namedmaterial2;
    void visit(ParamVisitor& v) {
      v(amount, "amount", kNonNegative, Unit::None, "weight of the first material");
      v(namedmaterial1, "namedmaterial1", "name of the first material (MakeNamedMaterial)");
      v(namedmaterial2, "namedmaterial2", "name of the second material");
    }
  };

  Mix(Params params, const FactoryContext& context)
      : params_(std::move(params)),
        first_(find(params_.namedmaterial1, "namedmaterial1", context)),
        second_(find(params_.namedmaterial2, "namedmaterial2", context)) {
    if (maxLobes() > Bsdf::kMaxLobes)
      throw SceneError(
          context.where,
          fmt::format("mix of '{}' and '{}' needs {} lobes; at most {} are possible",
                      params_.namedmaterial1, params_.namedmaterial2, maxLobes(), Bsdf::kMaxLobes));
    if (params_.amount.isConstant() && params_.amount.constant.maxChannel() > 1.f)
      context.log->warning(context.where,
                           "amount above 1: the first material is amplified and the second is "
                           "not seen");
  }

  bool hasSpecular() const override {
    return (isFirstSeen() && first_.hasSpecular()) || (isSecondSeen() && second_.hasSpecular());
  }
  bool hasNonSpecular() const override {
    return (isFirstSeen() && first_.hasNonSpecular()) ||
           (isSecondSeen() && second_.hasNonSpecular());
  }
  int maxLobes() const override {
    return (isFirstSeen() ? first_.maxLobes() : 0) + (isSecondSeen() ? second_.maxLobes() : 0);
  }
  const FloatSlot* bumpMap() const override { return first_.bumpMap(); }
  bool usesTangents() const override { return first_.usesTangents() || second_.usesTangents(); }

  void addLobes(const SurfaceInteraction& at, Bsdf& bsdf) const override {
    const Rgb amount = reflectanceAt(params_.amount, at);
    const Rgb rest = max(Rgb(1.f) - amount, 0.f);
    const Rgb before = bsdf.scale();
    if (!amount.isBlack()) {
      bsdf.setScale(before * amount);
      first_.addLobes(at, bsdf);
    }
    if (!rest.isBlack()) {
      bsdf.setScale(before * rest);
      second_.addLobes(at, bsdf);
    }
    bsdf.setScale(before);
  }

 private:
  static const Material& find(const std::string& name, const char* parameter,
                              const FactoryContext& context) {
    if (name.empty())
      throw SceneError(context.where,
                       fmt::format("Material 'mix' needs the parameter 'string {}'", parameter));
    const Material* material = context.named ? context.named->findMaterial(name) : nullptr;
    if (material) return *material;
    const std::vector<std::string> names =
        context.named ? context.named->materialNames() : std::vector<std::string>();
    throw SceneError(
        context.where,
        fmt::format("mix: no material is named '{}'{}{}", name, nearestSpelling(name, names),
                    names.empty() ? "" : "; there is " + listChoices(names)));
  }
  bool isFirstSeen() const { return canBeNonBlack(params_.amount); }
  bool isSecondSeen() const {
    return !params_.amount.isConstant() || params_.amount.constant.minChannel() < 1.f;
  }

  Params params_;
  const Material& first_;
  const Material& second_;
};

const RegisterPlugin<Material, Mix> kRegistration{"mix", Origin::PbrtV2,
                                                  "weighted sum of two named materials"};

}  // namespace
}  // namespace brume
