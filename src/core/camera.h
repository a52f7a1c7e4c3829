// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "core/params.h"
#include "core/ray.h"
#include "core/sampler.h"
#include "core/transform.h"

namespace brume {

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
};

}  // namespace brume
