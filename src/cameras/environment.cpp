// SPDX-License-Identifier: Apache-2.0
#include "core/camera.h"
#include "core/log.h"
#include "core/registry.h"

namespace brume {
namespace {

/// All directions at once, in a lat-long image with camera y up:
///   theta = pi y / yresolution, phi = 2 pi x / xresolution
///   d = (sin theta cos phi, cos theta, sin theta sin phi)
/// Test: camera_test.
class EnvironmentCamera final : public Camera {
 public:
  struct Params : CameraParams {
    void visit(ParamVisitor& v) { CameraParams::visit(v); }
  };

  EnvironmentCamera(const Params& params, const FactoryContext& context)
      : Camera(params, context),
        radiansPerPixel_(2.0 * M_PI / context.resolution.x, M_PI / context.resolution.y) {
    const auto ignored = [&context](const char* what) {
      context.log->warning(
          context.where,
          std::string("the environment camera sees all directions from one point: ") + what +
              " has no effect");
    };
    if (params.lensradius > 0) ignored("lensradius");
    if (params.screenwindow) ignored("screenwindow");
    if (params.frameaspectratio) ignored("frameaspectratio");
  }

  FootprintRay generateRay(const CameraSample& sample) const override {
    const float time = timeAt(sample.time);
    const CameraPose pose = poseAt(time);
    const Vec2 angle = radiansPerPixel_ * sample.raster, nextAngle = angle + radiansPerPixel_;
    const auto direction = [&pose](float phi, float theta) {
      const float s = std::sin(theta);
      return normalize(pose.vector({s * std::cos(phi), std::cos(theta), s * std::sin(phi)}));
    };
    const Vec3 o = pose.origin;
    return {
        Ray{o, direction(angle.x, angle.y), kInfinity, time},
        RayDifferential{o, o, direction(nextAngle.x, angle.y), direction(angle.x, nextAngle.y)}};
  }

 private:
  Vec2 radiansPerPixel_;
};

const RegisterPlugin<Camera, EnvironmentCamera> kRegistration{
    "environment", Origin::PbrtV2, "all directions around a point, as a lat-long image"};

}  // namespace
}  // namespace brume
