// SPDX-License-Identifier: Apache-2.0
#include "core/camera.h"

#include <fmt/format.h>

#include "core/log.h"

namespace brume {

void CameraParams::visit(ParamVisitor& v) {
  v(shutteropen, "shutteropen", kAnyFloat, Unit::Time, "when the shutter opens");
  v(shutterclose, "shutterclose", kAnyFloat, Unit::Time, "when it closes");
  v(frameaspectratio, "frameaspectratio", kPositive, Unit::None,
    "width over height of the screen window; default: of the image in pixels");
  v(screenwindow, "screenwindow", kAnyFloat, Unit::None,
    "x0 x1 y0 y1 of the part of the screen plane that fills the image; default: -1 to 1 along the "
    "shorter axis");
  v(lensradius, "lensradius", kNonNegative, Unit::Length, "radius of the lens; 0 is a pinhole");
  v(focaldistance, "focaldistance", kPositive, Unit::Length,
    "distance of the plane that is in focus");
}

CameraPose::CameraPose(const Transform& cameraToWorld)
    : origin(cameraToWorld.point(Vec3(0))),
      x(cameraToWorld.vector({1, 0, 0})),
      y(cameraToWorld.vector({0, 1, 0})),
      z(cameraToWorld.vector({0, 0, 1})) {}

Camera::Camera(const CameraParams& params, const FactoryContext& context)
    : cameraToWorld_(context.cameraToWorld),
      stillPose_(context.cameraToWorld.start()),
      isMoving_(context.cameraToWorld.isAnimated()),
      shutterOpen_(params.shutteropen),
      shutterClose_(params.shutterclose) {
  if (shutterClose_ < shutterOpen_) {
    context.log->warning(context.where,
                         fmt::format("shutterclose {} is before shutteropen {}: they are exchanged",
                                     shutterClose_, shutterOpen_));
    std::swap(shutterOpen_, shutterClose_);
  }
  if (cameraToWorld_.start().hasScale() || (isMoving_ && cameraToWorld_.end().hasScale()))
    context.log->warning(
        context.where,
        "the camera's transform has a scale: lens, focal distance and angles are scaled with it");
}

ScreenWindow::ScreenWindow(const CameraParams& params, const Camera::FactoryContext& context) {
  const Vec2 resolution(context.resolution);
  const float aspect = params.frameaspectratio.value_or(resolution.x / resolution.y);
  std::array<float, 4> window = aspect > 1.f ? std::array{-aspect, aspect, -1.f, 1.f}
                                             : std::array{-1.f, 1.f, -1.f / aspect, 1.f / aspect};
  if (params.screenwindow) window = *params.screenwindow;
  const auto [x0, x1, y0, y1] = window;
  topLeft = {x0, y1};
  perPixel = Vec2(x1 - x0, y0 - y1) / resolution;
  if (!(std::abs(perPixel.x) > 0) || !(std::abs(perPixel.y) > 0) || !std::isfinite(perPixel.x) ||
      !std::isfinite(perPixel.y))
    throw SceneError(context.where,
                     fmt::format("the screen window {} {} {} {} has no area", x0, x1, y0, y1));
}

}  // namespace brume
