// SPDX-License-Identifier: Apache-2.0
#include "core/light_map.h"
#include "core/log.h"
#include "core/registry.h"

namespace brume {
namespace {

/// Point light whose intensity is I times a lat-long map of directions, the pole along light-space
/// y:
///   s = atan2(z, x) / 2 pi, t = acos(y) / pi, bilinear
/// Power I integral(map dw). Test: light_test.
class GoniometricLight final : public Light {
 public:
  struct Params {
    Rgb I{1.f}, scale{1.f};
    Filename mapname;

    void visit(ParamVisitor& v) {
      v(I, "I", kAnyFloat, Unit::RadiantIntensity, "radiant intensity where the map is 1");
      v(scale, "scale", kAnyFloat, Unit::None, "multiplies I");
      v(mapname, "mapname", "lat-long image of the emission; without it the light is isotropic");
    }
  };

  GoniometricLight(const Params& params, const FactoryContext& context)
      : intensity_(params.I * params.scale),
        lightToWorld_(context.lightToWorld),
        worldToLight_(context.lightToWorld.inverse()),
        position_(Vec3d(context.lightToWorld.matrix()[3])),
        hasScale_(context.lightToWorld.hasScale()) {
    if (params.mapname.isGiven()) {
      map_.emplace(readLightMap(params.mapname, *context.log));
      distribution_ = LatLongDistribution(*map_, intensity_);
    } else {
      context.log->warning(context.where,
                           "a goniometric light without \"mapname\" emits alike in all directions");
    }
    if (hasScale_)
      context.log->warning(context.where,
                           "the goniometric light's transform has a scale: "
                           "directions in the map are deformed");
  }

  bool isDelta() const override { return true; }
  std::optional<LightSample> sampleLi(const Vec3& p, Vec2) const override {
    std::optional<LightSample> sample = samplePosition(p, position_);
    if (!sample) return sample;
    sample->L *= intensity_;
    if (map_) sample->L *= mapAt(-sample->wi);
    if (sample->L.isBlack()) return std::nullopt;
    return sample;
  }
  Rgb power() const override {
    return map_ ? intensity_ * map_->integral() : intensity_ * (4 * kPi);
  }
  float importance(const Bounds3& region) const override {
    return lightWeight(intensity_) * (map_ ? map_->maxWeight() : 1) *
           boundedInverseSquare(position_, region);
  }
  std::optional<LightBounds> bounds() const override {
    return pointBounds(position_, lightWeight(intensity_) * (map_ ? map_->maxWeight() : 1));
  }
  std::optional<Vec3> position() const override { return position_; }
  std::optional<LightEmission> sampleEmission(const Ball& target,
                                              const EmissionUniforms& u) const override;
  Rgb powerToward(const Ball& target) const override {
    const float seen = oneMinusCosSeen(position_, target);
    return map_ && !isSmall(seen) ? power() : intensity_ * (2 * kPi * seen * mapWeight());
  }

 private:
  /// Whether to aim at a target seen under this 1 - cos rather than follow the map.
  bool isSmall(float oneMinusCos) const { return hasScale_ || oneMinusCos < 0.25f; }
  float mapWeight() const { return map_ ? map_->maxWeight() : 1; }
  Rgb mapAt(const Vec3& w) const {
    const Vec3 local = worldToLight_.vector(w);
    return map_->at(Vec3(local.x, local.z, local.y));
  }

  Rgb intensity_;
  Transform lightToWorld_, worldToLight_;
  Vec3 position_;
  bool hasScale_;
  std::optional<LatLongMap> map_;
  LatLongDistribution distribution_;
};

/// By the map, or evenly towards a target that fills few directions.
std::optional<LightEmission> GoniometricLight::sampleEmission(const Ball& target,
                                                              const EmissionUniforms& u) const {
  if (map_ && !isSmall(oneMinusCosSeen(position_, target))) {
    const LatLongDistribution::Sample s = distribution_.sample(u.direction);
    if (!(s.pdf > 0)) return std::nullopt;
    const Vec3 w = lightToWorld_.vector(Vec3(s.w.x, s.w.z, s.w.y));
    return LightEmission{position_, normalize(w), intensity_ * map_->at(s.st) / s.pdf};
  }
  const AimedDirection aimed = aimAt(target, position_, u.direction);
  const Rgb I = map_ ? intensity_ * mapAt(aimed.w) : intensity_;
  if (I.isBlack()) return std::nullopt;
  return LightEmission{position_, aimed.w, I / aimed.pdf};
}

const RegisterPlugin<Light, GoniometricLight> kRegistration{
    "goniometric", Origin::PbrtV2, "point light with a measured distribution of directions"};

}  // namespace
}  // namespace brume
