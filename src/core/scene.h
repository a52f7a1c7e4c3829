// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/accelerator.h"
#include "core/coplanar_lights.h"
#include "core/file_cache.h"
#include "core/light.h"
#include "core/material.h"
#include "core/stats.h"
#include "core/volume.h"

namespace brume {

/// All that a scene file describes between WorldBegin and WorldEnd, immutable. Owns everything it
/// points to. Positions are in render space: the scene's world moved by -sceneOrigin, so that the
/// camera is at the origin and keeps its precision.
class Scene {
 public:
  /// What the SceneBuilder hands over.
  struct Contents {
    std::unique_ptr<FileCache> files;  ///< what textures and materials look at; or null
    std::vector<std::unique_ptr<Texture<float>>> floatTextures;
    std::vector<std::unique_ptr<Texture<Rgb>>> rgbTextures;
    std::vector<std::unique_ptr<Material>> materials;
    std::vector<std::unique_ptr<Shape>> shapes;
    std::vector<std::unique_ptr<Light>> lights;  ///< area lights included
    /// Area lights inside object definitions: they emit where they are seen, but nobody samples
    /// them.
    std::vector<std::unique_ptr<Light>> unsampledLights;
    std::vector<std::unique_ptr<Volume>> volumes;
    std::vector<PrimitiveGroup> groups{1};  ///< back() is the scene
    Vec3d sceneOrigin{0};
  };
  explicit Scene(Contents contents);

  /// First surface along the ray, with its material, light and footprint; counts the ray. Without
  /// a footprint its derivatives may be 0, unless the material uses tangents.
  std::optional<SurfaceInteraction> intersect(const FootprintRay& ray, Stats& stats) const;
  /// Whether anything lies on the ray before tMax.
  bool isOccluded(const Ray& ray, Stats& stats) const;

  /// The segment from a surface point towards a light sample, kept clear of both surfaces; tMax
  /// ends at the light.
  static Ray shadowRay(const SurfaceInteraction& from, const LightSample& to);
  /// The same from a point in a medium.
  static Ray shadowRay(const Vec3& from, float time, const LightSample& to);

  const std::vector<std::unique_ptr<Light>>& lights() const { return contents_.lights; }
  const std::vector<const Light*>& infiniteLights() const { return infiniteLights_; }
  /// The sum of all Volumes; null without any.
  const Volume* volume() const { return volume_; }
  /// Whether any surface moves.
  bool isMoving() const;
  const Bounds3& bounds() const { return bounds_; }  ///< of surfaces and volumes
  const Vec3d& sceneOrigin() const { return contents_.sceneOrigin; }
  const Contents& contents() const { return contents_; }
  const Accelerator& accelerator() const { return *accelerator_; }

 private:
  Contents contents_;
  SurfaceInteraction interactionAt(const FootprintRay& ray, const SceneHit& hit) const;
  std::optional<SurfaceInteraction> lightIn(const FootprintRay& ray, float t,
                                            const SurfaceInteraction& surface) const;

  std::unique_ptr<Accelerator> accelerator_;
  CoplanarLights coplanarLights_;
  std::unique_ptr<Volume> aggregate_;
  const Volume* volume_ = nullptr;
  std::vector<const Light*> infiniteLights_;
  Bounds3 bounds_;
};

}  // namespace brume
