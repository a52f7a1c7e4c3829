// SPDX-License-Identifier: Apache-2.0
#include "core/camera.h"
#include "core/registry.h"
#include "core/sampling.h"

namespace brume {
namespace {

/// Pinhole or thin lens. A raster position at screen (sx, sy) looks along
///   (sx tan(fov/2), sy tan(fov/2), 1)       camera space: x right, y up, z forward
/// so fov spans the shorter axis of the image. With a lens all rays of a position meet where that
/// line crosses the plane z = focaldistance. No vignetting, no exposure: a pixel is radiance.
/// Test: camera_test.
class PerspectiveCamera final : public Camera {
 public:
  struct Params : CameraParams {
    float fov = 90;
    std::optional<float> halffov;

    void visit(ParamVisitor& v) {
      v(fov, "fov", Range<float>{0.f, 179.99f, true}, Unit::Degrees,
        "field of view along the shorter axis of the image");
      v(halffov, "halffov", Range<float>{0.f, 89.995f, true}, Unit::Degrees,
        "half of the field of view; wins over fov");
      CameraParams::visit(v);
    }
  };

  PerspectiveCamera(const Params& params, const FactoryContext& context)
      : Camera(params, context),
        lensRadius_(params.lensradius),
        focalDistance_(params.focaldistance) {
    const float half = params.halffov.value_or(0.5f * params.fov);
    const float tangent = std::tan(radians(half));
    const ScreenWindow screen(params, context);
    topLeft_ = screen.topLeft * tangent;
    perPixel_ = screen.perPixel * tangent;
  }

  FootprintRay generateRay(const CameraSample& sample) const override {
    const float time = timeAt(sample.time);
    const CameraPose pose = poseAt(time);
    const Vec2 p = topLeft_ + perPixel_ * sample.raster;
    Vec3 origin = pose.origin, d = pose.vector({p.x, p.y, 1.f});
    if (lensRadius_ > 0) {
      // From the lens point to the point in focus, over focalDistance (which may be huge).
      const Vec2 lens = lensRadius_ * sampleConcentricDisk(sample.lens);
      const Vec3 shift = pose.x * lens.x + pose.y * lens.y;
      origin += shift;
      d -= shift / focalDistance_;
    }
    // The neighbours' rays leave from the same lens point.
    const Vec3 dx = d + pose.x * perPixel_.x, dy = d + pose.y * perPixel_.y;
    return {Ray{origin, normalize(d), kInfinity, time},
            RayDifferential{origin, origin, normalize(dx), normalize(dy)}};
  }

 private:
  Vec2 topLeft_{0}, perPixel_{0};  // of the plane z = 1 in camera space
  float lensRadius_, focalDistance_;
};

const RegisterPlugin<Camera, PerspectiveCamera> kRegistration{"perspective", Origin::PbrtV2,
                                                              "pinhole or thin lens"};

}  // namespace
}  // namespace brume
