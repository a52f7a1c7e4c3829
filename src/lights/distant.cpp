// SPDX-License-Identifier: Apache-2.0
#include "core/light.h"
#include "core/registry.h"

namespace brume {
namespace {

/// Parallel light from `from` towards `to`: irradiance L at normal incidence, everywhere. Power
/// pi R^2 L through the ball of radius R around the scene. Test: light_test.
class DistantLight final : public Light {
 public:
  struct Params {
    Rgb L{1.f}, scale{1.f};
    Vec3 from{0}, to{0, 0, 1};

    void visit(ParamVisitor& v) {
      v(L, "L", kAnyFloat, Unit::Radiance, "irradiance at normal incidence [W m^-2]");
      v(scale, "scale", kAnyFloat, Unit::None, "multiplies L");
      v.point(from, "from", Unit::Length, "where the light comes from");
      v.point(to, "to", Unit::Length, "where it goes to");
    }
  };

  DistantLight(const Params& params, const FactoryContext& context) : L_(params.L * params.scale) {
    const Transform lightToWorld =
        context.lightToWorld * lightFrame(params.from, params.to, context.where);
    towardsLight_ = Vec3(-normalize(Vec3d(lightToWorld.matrix()[2])));
  }

  bool isDelta() const override { return true; }
  void setSceneBounds(const Bounds3& bounds) override { scene_ = ballAround(bounds); }
  std::optional<LightSample> sampleLi(const Vec3&, Vec2) const override {
    LightSample sample;
    sample.L = L_;
    sample.wi = towardsLight_;
    sample.pdf = 1;
    return sample;
  }
  Rgb power() const override { return L_ * (kPi * sqr(scene_.radius)); }
  float importance(const Bounds3&) const override { return lightWeight(L_); }
  std::optional<LightEmission> sampleEmission(const Ball& target,
                                              const EmissionUniforms& u) const override {
    return LightEmission{startOfParallelRay(target, scene_, -towardsLight_, u.point),
                         -towardsLight_, powerToward(target)};
  }
  Rgb powerToward(const Ball& target) const override { return L_ * (kPi * sqr(target.radius)); }

 private:
  Rgb L_;
  Vec3 towardsLight_;
  Ball scene_;
};

const RegisterPlugin<Light, DistantLight> kRegistration{"distant", Origin::PbrtV2,
                                                        "parallel light from far away"};

}  // namespace
}  // namespace brume
