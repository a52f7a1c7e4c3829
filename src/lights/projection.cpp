// SPDX-License-Identifier: Apache-2.0
#include "core/light_map.h"
#include "core/log.h"
#include "core/registry.h"

namespace brume {
namespace {

/// Slide projector: intensity I times an image on the plane z = 1 of light space, shorter axis
/// spanning fov; the image's first row lies towards -y, as PBRT-v2. Nothing outside the image.
/// Power: the integral of I times image over solid angle, by the midpoint rule. Test: light_test.
class ProjectionLight final : public Light {
 public:
  struct Params {
    Rgb I{1.f}, scale{1.f};
    float fov = 45;
    Filename mapname;

    void visit(ParamVisitor& v) {
      v(I, "I", kAnyFloat, Unit::RadiantIntensity, "radiant intensity where the image is 1");
      v(scale, "scale", kAnyFloat, Unit::None, "multiplies I");
      v(fov, "fov", Range<float>{0.f, 179.99f, true}, Unit::Degrees,
        "angle that the shorter axis of the image spans");
      v(mapname, "mapname", "image to project; without it a white square");
    }
  };

  ProjectionLight(const Params& params, const FactoryContext& context)
      : intensity_(params.I * params.scale),
        worldToLight_(context.lightToWorld.inverse()),
        position_(Vec3d(context.lightToWorld.matrix()[3])),
        axis_(normalize(Vec3d(context.lightToWorld.matrix()[2]))),
        hasScale_(context.lightToWorld.hasScale()) {
    image_ = RgbImage(1, 1);
    image_.pixels[0] = Rgb(1);
    if (params.mapname.isGiven())
      image_ = readLightMap(params.mapname, *context.log);
    else
      context.log->warning(context.where,
                           "a projection light without \"mapname\" projects a white square");
    if (hasScale_)
      context.log->warning(context.where,
                           "the projection light's transform has a scale: the "
                           "image is deformed");
    const float aspect = static_cast<float>(image_.width) / static_cast<float>(image_.height);
    halfSize_ =
        std::tan(radians(0.5f * params.fov)) * (aspect > 1 ? Vec2(aspect, 1) : Vec2(1, 1 / aspect));
    edge_ = oneMinusCosTheta({halfSize_.x, halfSize_.y, 1});
    for (const Rgb& pixel : image_.pixels) maxWeight_ = std::max(maxWeight_, lightWeight(pixel));
    power_ = intensity_ * integral();
  }

  bool isDelta() const override { return true; }
  std::optional<LightSample> sampleLi(const Vec3& p, Vec2) const override {
    std::optional<LightSample> sample = samplePosition(p, position_);
    if (!sample) return sample;
    const Vec3 w = worldToLight_.vector(-sample->wi);
    if (!(w.z > 0)) return std::nullopt;
    const Vec2 onPlane(w.x / w.z, w.y / w.z);
    if (!(std::abs(onPlane.x) <= halfSize_.x && std::abs(onPlane.y) <= halfSize_.y))
      return std::nullopt;
    sample->L *= intensity_ * bilinear(image_, 0.5f * (onPlane / halfSize_ + Vec2(1)));
    if (sample->L.isBlack()) return std::nullopt;
    return sample;
  }
  Rgb power() const override { return power_; }
  float importance(const Bounds3& region) const override {
    if (!hasScale_ && smallestOneMinusCos(position_, axis_, region) > edge_) return 0;
    return lightWeight(intensity_) * maxWeight_ * boundedInverseSquare(position_, region);
  }
  std::optional<Vec3> position() const override { return position_; }

 private:
  /// Of the image over solid angle: dw = cos^3 theta dA on the plane z = 1.
  Rgb integral() const {
    // Two points per pixel, but a fixed number at least (curvature) and at most (time).
    const auto steps = [](int n) { return std::clamp(2 * n, 128, 1024); };
    const int nx = steps(image_.width), ny = steps(image_.height);
    double sum[3] = {0, 0, 0};
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        const double s = (x + 0.5) / nx, t = (y + 0.5) / ny;
        const double px = (2 * s - 1) * static_cast<double>(halfSize_.x),
                     py = (2 * t - 1) * static_cast<double>(halfSize_.y);
        const double r2 = 1 + px * px + py * py, cos3 = 1 / (r2 * std::sqrt(r2));
        const Rgb value = bilinear(image_, Vec2(s, t));
        for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(value[c]) * cos3;
      }
    const double area = 4 * static_cast<double>(halfSize_.x) * static_cast<double>(halfSize_.y);
    const double step = area / nx / ny;
    return {static_cast<float>(sum[0] * step), static_cast<float>(sum[1] * step),
            static_cast<float>(sum[2] * step)};
  }

  Rgb intensity_, power_;
  Transform worldToLight_;
  Vec3 position_, axis_;
  bool hasScale_;
  RgbImage image_;
  Vec2 halfSize_{1};  // of the image on the plane z = 1
  float edge_ = 0;    // 1 - cos of the angle to its corners
  float maxWeight_ = 0;
};

const RegisterPlugin<Light, ProjectionLight> kRegistration{"projection", Origin::PbrtV2,
                                                           "point light that projects an image"};

}  // namespace
}  // namespace brume
