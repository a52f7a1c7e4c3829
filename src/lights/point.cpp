// SPDX-License-Identifier: Apache-2.0
#include "core/light.h"
#include "core/registry.h"

namespace brume {
namespace {

/// Isotropic point of radiant intensity I: irradiance I / d^2 at normal incidence, power 4 pi I.
/// The position is `from` added to the origin of the transform, after it, as PBRT-v2. Test:
/// light_test.
class PointLight final : public Light {
 public:
  struct Params {
    Rgb I{1.f}, scale{1.f};
    Vec3 from{0};

    void visit(ParamVisitor& v) {
      v(I, "I", kAnyFloat, Unit::RadiantIntensity, "radiant intensity");
      v(scale, "scale", kAnyFloat, Unit::None, "multiplies I");
      v.point(from, "from", Unit::Length, "position, added after the transform");
    }
  };

  PointLight(const Params& params, const FactoryContext& context)
      : intensity_(params.I * params.scale),
        position_(Vec3d(context.lightToWorld.matrix()[3]) + Vec3d(params.from)) {}

  bool isDelta() const override { return true; }
  std::optional<LightSample> sampleLi(const Vec3& p, Vec2) const override {
    std::optional<LightSample> sample = samplePosition(p, position_);
    if (sample) sample->L *= intensity_;
    return sample;
  }
  Rgb power() const override { return intensity_ * (4 * kPi); }
  float importance(const Bounds3& region) const override {
    return lightWeight(intensity_) * boundedInverseSquare(position_, region);
  }
  std::optional<LightBounds> bounds() const override {
    return pointBounds(position_, lightWeight(intensity_));
  }
  std::optional<Vec3> position() const override { return position_; }
  std::optional<LightEmission> sampleEmission(const Ball& target,
                                              const EmissionUniforms& u) const override {
    const AimedDirection aimed = aimAt(target, position_, u.direction);
    return LightEmission{position_, aimed.w, intensity_ / aimed.pdf};
  }
  Rgb powerToward(const Ball& target) const override {
    return intensity_ * (2 * kPi * oneMinusCosSeen(position_, target));
  }

 private:
  Rgb intensity_;
  Vec3 position_;
};

const RegisterPlugin<Light, PointLight> kRegistration{"point", Origin::PbrtV2,
                                                      "isotropic point light"};

}  // namespace
}  // namespace brume
