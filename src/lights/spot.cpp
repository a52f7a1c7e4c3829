// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/light.h"
#include "core/log.h"
#include "core/registry.h"

namespace brume {
namespace {

/// 1 - cos of an angle in degrees.
float oneMinusCos(float degrees) {
  return static_cast<float>(2 * sqr(std::sin(0.5 * static_cast<double>(degrees) * M_PI / 180)));
}

/// Point light in a cone around from -> to:
///   I(theta) = I for theta <= theta_s, I ((cos theta - cos theta_t) / (cos theta_s - cos
///   theta_t))^4 up to theta_t = coneangle, 0 beyond; theta_s = coneangle - conedeltaangle
/// Power 2 pi I (1 - cos theta_s + (cos theta_s - cos theta_t) / 5). Test: light_test.
class SpotLight final : public Light {
 public:
  struct Params {
    Rgb I{1.f}, scale{1.f};
    Vec3 from{0}, to{0, 0, 1};
    float coneangle = 30, conedeltaangle = 5;

    void visit(ParamVisitor& v) {
      v(I, "I", kAnyFloat, Unit::RadiantIntensity, "radiant intensity on the axis");
      v(scale, "scale", kAnyFloat, Unit::None, "multiplies I");
      v.point(from, "from", Unit::Length, "position");
      v.point(to, "to", Unit::Length, "a point on the axis");
      v(coneangle, "coneangle", Range<float>{0.f, 180.f, true}, Unit::Degrees,
        "angle between the axis and the border of the cone");
      v(conedeltaangle, "conedeltaangle", Range<float>{0.f, 180.f}, Unit::Degrees,
        "width of the falloff inside the border");
    }
  };

  SpotLight(const Params& params, const FactoryContext& context)
      : intensity_(params.I * params.scale), edge_(oneMinusCos(params.coneangle)) {
    const Transform lightToWorld =
        context.lightToWorld * lightFrame(params.from, params.to, context.where);
    worldToLight_ = lightToWorld.inverse();
    position_ = Vec3(Vec3d(lightToWorld.matrix()[3]));
    axis_ = Vec3(normalize(Vec3d(lightToWorld.matrix()[2])));
    hasScale_ = lightToWorld.hasScale();
    if (hasScale_)
      context.log->warning(context.where,
                           "the spot light's transform has a scale: its cone is "
                           "deformed, its intensity is not");
    // PBRT-v2 takes the cosine of the difference, whatever its sign.
    const float start = std::abs(params.coneangle - params.conedeltaangle);
    if (params.conedeltaangle > params.coneangle) {
      const std::string text = fmt::format("conedeltaangle {} is more than coneangle {}",
                                           params.conedeltaangle, params.coneangle);
      if (start > params.coneangle) throw SceneError(context.where, text);
      context.log->warning(context.where,
                           text + fmt::format(": the falloff begins at {} degrees", start));
    }
    falloffStart_ = oneMinusCos(start);
  }

  bool isDelta() const override { return true; }
  std::optional<LightSample> sampleLi(const Vec3& p, Vec2) const override {
    std::optional<LightSample> sample = samplePosition(p, position_);
    if (!sample) return sample;
    const float f = falloff(oneMinusCosTheta(worldToLight_.vector(-sample->wi)));
    if (f == 0) return std::nullopt;
    sample->L *= intensity_ * f;
    return sample;
  }
  Rgb power() const override {
    return intensity_ * (2 * kPi * (falloffStart_ + (edge_ - falloffStart_) / 5));
  }
  float importance(const Bounds3& region) const override {
    // A cone deformed by a scale has no angle to test.
    const float f = hasScale_ ? 1 : falloff(smallestOneMinusCos(position_, axis_, region));
    return lightWeight(intensity_) * boundedInverseSquare(position_, region) * f;
  }
  std::optional<Vec3> position() const override { return position_; }

 private:
  float falloff(float omc) const {
    if (omc >= edge_) return 0;
    if (omc <= falloffStart_) return 1;
    return sqr(sqr((edge_ - omc) / (edge_ - falloffStart_)));
  }

  Rgb intensity_;
  float edge_, falloffStart_ = 0;  // 1 - cos of the two angles
  Transform worldToLight_;
  Vec3 position_, axis_;
  bool hasScale_ = false;
};

const RegisterPlugin<Light, SpotLight> kRegistration{"spot", Origin::PbrtV2,
                                                     "point light in a cone with a soft border"};

}  // namespace
}  // namespace brume
