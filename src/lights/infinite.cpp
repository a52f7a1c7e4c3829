// SPDX-License-Identifier: Apache-2.0
#include "core/light_map.h"
#include "core/log.h"
#include "core/registry.h"

namespace brume {
namespace {

/// Radiance from all around: L * scale, times a lat-long map with light-space z up,
///   s = phi / 2 pi (from +x towards +y), t = theta / pi, the first row around +z; bilinear
/// A map is sampled in proportion to the mean luminance of its interpolant over each pixel times
/// solid angle (exactly the density that pdfLi returns: no bias); a constant uniformly. Power
/// pi R^2 integral(L dw) through the ball of radius R around the scene. "exinfinite" is a
/// second name. Test: light_test.
class InfiniteLight final : public Light {
 public:
  struct Params {
    Rgb L{1.f}, scale{1.f};
    Filename mapname;
    int nsamples = 1;

    void visit(ParamVisitor& v) {
      v(L, "L", kAnyFloat, Unit::Radiance, "radiance; multiplies the map");
      v(scale, "scale", kAnyFloat, Unit::None, "multiplies L");
      v(mapname, "mapname", "lat-long image; default: constant radiance");
      v(nsamples, "nsamples", kPositiveInt, Unit::Samples,
        "shadow rays per point for \"directlighting\"");
    }
  };

  InfiniteLight(const Params& params, const FactoryContext& context)
      : L_(params.L * params.scale),
        sampleCount_(context.quick ? std::max(1, params.nsamples / 4) : params.nsamples),
        lightToWorld_(context.lightToWorld),
        worldToLight_(context.lightToWorld.inverse()) {
    if (params.mapname.isGiven()) {
      map_.emplace(readLightMap(params.mapname, *context.log));
      distribution_ = LatLongDistribution(*map_, L_);
    }
    fluence_ = map_ ? L_ * map_->integral() : L_ * (4 * kPi);
    if (lightToWorld_.hasScale()) {
      const glm::dmat3 linear(lightToWorld_.matrix());
      volume_ = static_cast<float>(std::abs(dot(linear[0], cross(linear[1], linear[2]))));
      if (map_)
        context.log->warning(context.where,
                             "the infinite light's transform has a scale: "
                             "directions in the map are deformed");
    }
  }

  bool isDelta() const override { return false; }
  bool isInfinite() const override { return true; }
  int sampleCount() const override { return sampleCount_; }
  void setSceneBounds(const Bounds3& bounds) override { scene_ = ballAround(bounds); }

  std::optional<LightSample> sampleLi(const Vec3&, Vec2 u) const override {
    LightSample sample;
    if (!map_) {
      sample.wi = sampleUniformSphere(u);
      sample.pdf = kInv4Pi;
      sample.L = L_;
      return sample;
    }
    const LatLongDistribution::Sample direction = distribution_.sample(u);
    const Vec3 wi = lightToWorld_.vector(direction.w);
    sample.wi = normalize(wi);
    sample.pdf = direction.pdf * stretch(wi);
    sample.L = L_ * map_->at(direction.st);
    if (!(sample.pdf > 0) || !std::isfinite(sample.pdf) || sample.L.isBlack()) return std::nullopt;
    return sample;
  }
  float pdfLi(const Vec3&, const Vec3& wi) const override {
    if (!map_) return kInv4Pi;
    const Vec3 w = normalize(worldToLight_.vector(wi));
    return distribution_.pdf(w) * stretch(lightToWorld_.vector(w));
  }
  Rgb Le(const Ray& ray) const override {
    return map_ ? L_ * map_->at(worldToLight_.vector(ray.d)) : L_;
  }
  Rgb power() const override { return fluence_ * (kPi * sqr(scene_.radius)); }
  float importance(const Bounds3&) const override { return lightWeight(fluence_); }
  std::optional<LightEmission> sampleEmission(const Ball& target,
                                              const EmissionUniforms& u) const override {
    const auto from = sampleLi(target.center, u.direction);
    if (!from) return std::nullopt;
    return LightEmission{startOfParallelRay(target, scene_, -from->wi, u.point), -from->wi,
                         from->L * (kPi * sqr(target.radius) / from->pdf)};
  }
  Rgb powerToward(const Ball& target) const override {
    return fluence_ * (kPi * sqr(target.radius));
  }

 private:
  /// Density factor of a transform with scale for the image w of a unit vector: |w|^3 / det.
  float stretch(const Vec3& w) const {
    return volume_ == 0 ? 1 : lengthSquared(w) * length(w) / volume_;
  }

  Rgb L_;
  int sampleCount_;
  Transform lightToWorld_, worldToLight_;
  std::optional<LatLongMap> map_;
  LatLongDistribution distribution_;
  Rgb fluence_;       // integral of the radiance over all directions
  float volume_ = 0;  // of the transformed unit cube; 0: no scale
  Ball scene_;
};

const RegisterPlugin<Light, InfiniteLight> kRegistration{
    "infinite", Origin::PbrtV2, "radiance from all around, constant or a lat-long image"};
const RegisterPlugin<Light, InfiniteLight> kAlias{"exinfinite", Origin::PbrtV2,
                                                  "the same as \"infinite\""};

}  // namespace
}  // namespace brume
