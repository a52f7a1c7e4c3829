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
        worldToLight_(context.lightToWorld.inverse()),
        position_(Vec3d(context.lightToWorld.matrix()[3])) {
    if (params.mapname.isGiven())
      map_.emplace(readLightMap(params.mapname, *context.log));
    else
      context.log->warning(context.where,
                           "a goniometric light without \"mapname\" emits alike in all directions");
    if (context.lightToWorld.hasScale())
      context.log->warning(context.where,
                           "the goniometric light's transform has a scale: "
                           "directions in the map are deformed");
  }

  bool isDelta() const override { return true; }
  std::optional<LightSample> sampleLi(const Vec3& p, Vec2) const override {
    std::optional<LightSample> sample = samplePosition(p, position_);
    if (!sample) return sample;
    sample->L *= intensity_;
    if (map_) {
      const Vec3 w = worldToLight_.vector(-sample->wi);
      sample->L *= map_->at(Vec3(w.x, w.z, w.y));
    }
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
  std::optional<Vec3> position() const override { return position_; }

 private:
  Rgb intensity_;
  Transform worldToLight_;
  Vec3 position_;
  std::optional<LatLongMap> map_;
};

const RegisterPlugin<Light, GoniometricLight> kRegistration{
    "goniometric", Origin::PbrtV2, "point light with a measured distribution of directions"};

}  // namespace
}  // namespace brume
