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
        lightToWorld_(context.lightToWorld),
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
    distribution_ = makeDistribution();
  }

  bool isDelta() const override { return true; }
  std::optional<LightSample> sampleLi(const Vec3& p, Vec2) const override {
    std::optional<LightSample> sample = samplePosition(p, position_);
    if (!sample) return sample;
    sample->L *= intensity_ * imageToward(-sample->wi);
    if (sample->L.isBlack()) return std::nullopt;
    return sample;
  }
  Rgb power() const override { return power_; }
  float importance(const Bounds3& region) const override {
    if (!hasScale_ && smallestOneMinusCos(position_, axis_, region) > edge_) return 0;
    return lightWeight(intensity_) * maxWeight_ * boundedInverseSquare(position_, region);
  }
  std::optional<LightBounds> bounds() const override {
    LightBounds b = pointBounds(position_, lightWeight(intensity_) * maxWeight_);
    // An image deformed by a scale has no angle.
    if (!hasScale_) {
      b.axes = DirectionCone::around(axis_);
      b.cosEmission = 1 - edge_;
    }
    return b;
  }
  std::optional<Vec3> position() const override { return position_; }
  std::optional<LightEmission> sampleEmission(const Ball& target,
                                              const EmissionUniforms& u) const override;
  Rgb powerToward(const Ball& target) const override {
    if (!hasScale_) return power_;
    return intensity_ * (maxWeight_ * 2 * kPi * oneMinusCosSeen(position_, target));
  }

 private:
  /// The image in a direction of render space; 0 outside.
  Rgb imageToward(const Vec3& direction) const {
    const Vec3 w = worldToLight_.vector(direction);
    if (!(w.z > 0)) return {};
    const Vec2 onPlane(w.x / w.z, w.y / w.z);
    if (!(std::abs(onPlane.x) <= halfSize_.x && std::abs(onPlane.y) <= halfSize_.y)) return {};
    return bilinear(image_, 0.5f * (onPlane / halfSize_ + Vec2(1)));
  }
  Distribution2D makeDistribution() const;

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
  Transform lightToWorld_, worldToLight_;
  Vec3 position_, axis_;
  bool hasScale_;
  RgbImage image_;
  Vec2 halfSize_{1};  // of the image on the plane z = 1
  float edge_ = 0;    // 1 - cos of the angle to its corners
  float maxWeight_ = 0;
  Distribution2D distribution_;  // of emission directions, over the image
};

/// Per pixel: the mean of image times cos^3 theta. Nine points of a pixel span all pieces of the
/// bilinear interpolant, so the density is 0 only where the image is.
Distribution2D ProjectionLight::makeDistribution() const {
  const auto width = static_cast<std::size_t>(image_.width),
             height = static_cast<std::size_t>(image_.height);
  std::vector<float> weights(width * height);
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) {
      float sum = 0;
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i) {
          const Vec2 st(
              (static_cast<float>(x) + 0.5f * static_cast<float>(i)) / static_cast<float>(width),
              (static_cast<float>(y) + 0.5f * static_cast<float>(j)) / static_cast<float>(height));
          const Vec2 p = (2.f * st - Vec2(1)) * halfSize_;
          const float r2 = 1 + dot(p, p);
          sum += lightWeight(bilinear(image_, st)) / (r2 * std::sqrt(r2));
        }
      weights[y * width + x] = sum;
    }
  return {weights, width, height};
}

/// By the image; evenly towards the target where a scale deforms the image.
std::optional<LightEmission> ProjectionLight::sampleEmission(const Ball& target,
                                                             const EmissionUniforms& u) const {
  if (hasScale_) {
    const AimedDirection aimed = aimAt(target, position_, u.direction);
    const Rgb image = imageToward(aimed.w);
    if (image.isBlack()) return std::nullopt;
    return LightEmission{position_, aimed.w, intensity_ * image / aimed.pdf};
  }
  const Distribution2D::Sample s = distribution_.sample(u.direction);
  if (!(s.pdf > 0)) return std::nullopt;
  // dw = cos^3 theta dA, and the image covers 4 x y of the plane z = 1.
  const Vec2 p = (2.f * s.p - Vec2(1)) * halfSize_;
  const float r2 = 1 + dot(p, p);
  const float solidAngle = 4 * halfSize_.x * halfSize_.y / (r2 * std::sqrt(r2) * s.pdf);
  return LightEmission{position_, normalize(lightToWorld_.vector(Vec3(p.x, p.y, 1))),
                       intensity_ * bilinear(image_, s.p) * solidAngle};
}

const RegisterPlugin<Light, ProjectionLight> kRegistration{"projection", Origin::PbrtV2,
                                                           "point light that projects an image"};

}  // namespace
}  // namespace brume
