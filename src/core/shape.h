// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "core/interaction.h"
#include "core/light_bounds.h"
#include "core/params.h"
#include "core/transform.h"

namespace brume {

/// Where a ray meets a shape, as the accelerator reports it.
struct ShapeHit {
  float t = 0;
  float u = 0, v = 0;           ///< barycentrics of vertices 1 and 2; unused by quadrics
  std::uint32_t primitive = 0;  ///< triangle index; 0 for quadrics
};

/// A point on a shape, sampled for area light.
struct ShapeSample {
  Vec3 p{0};
  Vec3 pError{0};
  Vec3 n{0, 0, 1};  ///< unit, on the side that the hit normal shows
  float pdf = 0;    ///< solid angle at the reference point, or per area for sampleArea
};

class TriangleMesh;

/// A surface. Its own space is render space, or the space of the object definition or of the moving
/// object that it belongs to: "shape space" below; quadrics keep their object space to themselves.
class Shape {
 public:
  static constexpr std::string_view kPluginKind = "Shape";
  struct FactoryContext {
    Transform objectToShape;  ///< CTM, with the shift to render space where that applies
    bool reverseOrientation = false;
    Vec3d sceneOrigin{0};  ///< what shape space is shifted by: p in scene space is p + sceneOrigin
    SourceLocation where;
    Log* log = nullptr;
    /// Flip of the normal: ReverseOrientation xor a mirroring transform.
    bool flipsNormal() const { return reverseOrientation != objectToShape.swapsHandedness(); }
  };

  virtual ~Shape() = default;

  virtual Bounds3 bounds() const = 0;
  virtual float area() const = 0;
  /// Holds the normals of all points.
  virtual DirectionCone normals() const { return {}; }
  /// Shapes made of triangles return their mesh and are intersected by Embree itself.
  virtual const TriangleMesh* mesh() const { return nullptr; }
  /// Other shapes: nearest hit with 0 < t < ray.tMax. The ray's direction need not be normalised.
  virtual std::optional<ShapeHit> intersect(const Ray& ray) const;
  /// Everything that the shape knows of the hit: p with its error bound, normals, uv, derivatives.
  /// Not wo, time and material.
  virtual SurfaceInteraction interaction(const Ray& ray, const ShapeHit& hit) const = 0;
  /// The same; shapes to whom they cost something may leave the derivatives at 0.
  virtual SurfaceInteraction interactionWithoutDerivatives(const Ray& ray,
                                                           const ShapeHit& hit) const {
    return interaction(ray, hit);
  }

  /// False: the shape cannot be an area light, and AreaLightSource on it is an error.
  virtual bool canSample() const { return true; }
  /// A point by area; pdf per area. Uniform, except on a quadric whose transform scales its axes
  /// differently.
  virtual ShapeSample sampleArea(Vec2 u) const = 0;
  /// Density per area of sampleArea at a point of the shape with its normal.
  virtual float pdfArea(const Vec3& p, const Vec3& n) const;
  /// A point as seen from ref, pdf per solid angle; by default sampleArea with its pdf converted.
  /// None when degenerate.
  virtual std::optional<ShapeSample> sampleSolidAngle(const Vec3& ref, Vec2 u) const;
  /// Density per solid angle of sampleSolidAngle for the direction wi, which meets the shape at
  /// `hit` (its p, n).
  virtual float pdfSolidAngle(const Vec3& ref, const Vec3& wi, const Vec3& hitPoint,
                              const Vec3& hitNormal) const;
};

}  // namespace brume
