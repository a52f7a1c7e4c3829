// SPDX-License-Identifier: Apache-2.0
#include "core/camera.h"
#include "core/registry.h"
#include "core/sampling.h"

namespace brume {
namespace {

/// Parallel rays along camera z from the plane z = 0; the screen window is in camera-space lengths.
/// With lensradius > 0 each raster position has a lens of its own around its origin, and all its
/// rays meet on the plane z = focaldistance. (PBRT-v2 puts every lens around the camera's origin,
/// which folds the image into a point: a fault.) Test: camera_test.
class OrthographicCamera final : public Camera {
 public:
  struct Params : CameraParams {
    void visit(ParamVisitor& v) { CameraParams::visit(v); }
  };

  OrthographicCamera(const Params& params, const FactoryContext& context)
      : Camera(params, context),
        screen_(params, context),
        lensRadius_(params.lensradius),
        focalDistance_(params.focaldistance) {}

  FootprintRay generateRay(const CameraSample& sample) const override {
    const float time = timeAt(sample.time);
    const CameraPose pose = poseAt(time);
    const Vec2 p = screen_.at(sample.raster);
    Vec3 origin = pose.point({p.x, p.y, 0}), d = pose.z;
    if (lensRadius_ > 0) {
      const Vec2 lens = lensRadius_ * sampleConcentricDisk(sample.lens);
      const Vec3 shift = pose.x * lens.x + pose.y * lens.y;
      origin += shift;
      d -= shift / focalDistance_;
    }
    d = normalize(d);
    return {Ray{origin, d, kInfinity, time},
            RayDifferential{origin + pose.x * screen_.perPixel.x,
                            origin + pose.y * screen_.perPixel.y, d, d}};
  }

 private:
  ScreenWindow screen_;
  float lensRadius_, focalDistance_;
};

const RegisterPlugin<Camera, OrthographicCamera> kRegistration{"orthographic", Origin::PbrtV2,
                                                               "parallel projection"};

}  // namespace
}  // namespace brume
