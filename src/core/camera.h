// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "core/params.h"
#include "core/ray.h"
#include "core/sampler.h"
#include "core/transform.h"

namespace brume {

/// What the cameras of PBRT-v2 have in common.
struct CameraParams {
  float shutteropen = 0, shutterclose = 1;
  std::optional<float> frameaspectratio;
  std::optional<std::array<float, 4>> screenwindow;
  float lensradius = 0, focaldistance = 1e30f;

  void visit(ParamVisitor& v);
};

/// Position and axes of camera space in render space; the axes carry the scale of the camera's
/// transform, if any.
struct CameraPose {
  Vec3 origin{0}, x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

  CameraPose() = default;
  explicit CameraPose(const Transform& cameraToWorld);
  Vec3 vector(const Vec3& v) const { return x * v.x + y * v.y + z * v.z; }
  Vec3 point(const Vec3& p) const { return origin + vector(p); }
};

/// Maps raster positions to rays in render space. Immutable and thread-safe.
class Camera {
 public:
  static constexpr std::string_view kPluginKind = "Camera";
  struct FactoryContext {
    AnimatedTransform
        cameraToWorld;           ///< render space: the camera sits at the origin at the start time
    Vec2i resolution{640, 480};  ///< of the full image, not of the crop window
    SourceLocation where;
    Log* log = nullptr;
  };
  virtual ~Camera() = default;
  /// The ray through a sample, with the footprint of one pixel (scaled by the caller for several
  /// samples).
  virtual FootprintRay generateRay(const CameraSample& sample) const = 0;
  /// Times between which the shutter is open.
  Interval shutter() const { return {shutterOpen_, shutterClose_}; }

 protected:
  /// Checks the shutter and warns of a scale in the camera's transform.
  Camera(const CameraParams& params, const FactoryContext& context);

  /// Unit interval to shutter time.
  float timeAt(float u) const { return lerp(shutterOpen_, shutterClose_, u); }
  /// The pose at a time; a still camera's is computed once.
  CameraPose poseAt(float time) const {
    return isMoving_ ? CameraPose(cameraToWorld_.at(time)) : stillPose_;
  }

 private:
  AnimatedTransform cameraToWorld_;
  CameraPose stillPose_;
  bool isMoving_ = false;
  float shutterOpen_ = 0, shutterClose_ = 1;
};

/// The part of the screen plane that the image shows: raster to screen coordinates, y up.
struct ScreenWindow {
  Vec2 topLeft{-1, 1};  ///< at raster (0, 0)
  Vec2 perPixel{0};     ///< change of screen position per pixel; y is negative by default

  /// PBRT-v2's window: [-1, 1] along the shorter axis of the frame, unless given.
  ScreenWindow(const CameraParams& params, const Camera::FactoryContext& context);
  Vec2 at(Vec2 raster) const { return topLeft + perPixel * raster; }
};

}  // namespace brume
