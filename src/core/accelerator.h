// SPDX-License-Identifier: Apache-2.0
// The interface to ray-surface intersection; src/accelerators implements it with Embree.
#pragma once

#include <memory>
#include <vector>

#include "core/interaction.h"
#include "core/shape.h"
#include "core/transform.h"

namespace brume {

/// One shape with what it is made of.
struct Primitive {
  const Shape* shape = nullptr;
  const Material* material = nullptr;    ///< never null
  const AreaLight* areaLight = nullptr;  ///< or null
};

/// A group of primitives in one space: the scene itself, an object definition, or a moving shape.
struct PrimitiveGroup {
  std::vector<Primitive> primitives;
  struct Instance {
    std::size_t group = 0;  ///< index of another, earlier group
    AnimatedTransform groupToParent;
  };
  std::vector<Instance> instances;  ///< only in the last group, the scene (definitions do not nest)
};

/// Where a ray first meets the scene; enough to compute the rest.
struct SceneHit {
  ShapeHit shape;
  const Primitive* primitive = nullptr;
  const PrimitiveGroup::Instance* instance = nullptr;  ///< or null
};

/// Nearest-hit and any-hit queries in render space. Immutable and thread-safe.
class Accelerator {
 public:
  virtual ~Accelerator() = default;
  virtual std::optional<SceneHit> intersect(const Ray& ray) const = 0;
  virtual bool occluded(const Ray& ray) const = 0;
  virtual Bounds3 bounds() const = 0;
  /// Bytes of the structure itself (without the meshes).
  virtual std::size_t memoryBytes() const = 0;
  /// The most that it took while it was built.
  virtual std::size_t peakMemoryBytes() const = 0;
};

/// groups.back() is the scene. The groups outlive the accelerator.
std::unique_ptr<Accelerator> buildEmbreeAccelerator(const std::vector<PrimitiveGroup>& groups);

}  // namespace brume
