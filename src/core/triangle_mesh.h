// SPDX-License-Identifier: Apache-2.0
// Indexed triangles with optional per-vertex normals, tangents and uv, shared by all shapes that
// are made of triangles.
#pragma once

#include <array>
#include <mutex>

#include "core/shape.h"

namespace brume {

/// Raw data of a mesh in object space; the TriangleMesh constructor checks it.
struct MeshData {
  std::vector<int> indices;  ///< 3 per triangle, each in [0, points.size())
  std::vector<Vec3> points;
  std::vector<Vec3> normals;       ///< empty or one per point
  std::vector<Vec3> tangents;      ///< empty or one per point
  std::vector<float> uvs;          ///< empty or two per point
  std::optional<FloatSlot> alpha;  ///< cut where it is exactly 0
  bool discardDegenerateUvs = false;
};

/// Triangles in shape space; the plugins made of triangles derive from it. n follows the winding
/// (not the sign of the uv, as in PBRT-v2). Sampling is uniform by area (area CDF over triangles).
class TriangleMesh : public Shape {
 public:
  /// Takes over the data and transforms it by context.objectToShape. SceneError for indices out of
  /// range, lists of different lengths, points that are not finite or beyond Embree's range.
  TriangleMesh(MeshData data, const FactoryContext& context);

  std::uint32_t triangleCount() const {
    return static_cast<std::uint32_t>(data_.indices.size() / 3);
  }
  /// For Embree's shared buffers: 3 unsigned per triangle, 3 floats per vertex (16 readable bytes
  /// behind the last one).
  const int* indexData() const { return data_.indices.data(); }
  const Vec3* pointData() const { return data_.points.data(); }
  std::size_t pointCount() const { return data_.points.size() - 1; }
  bool hasAlpha() const { return data_.alpha.has_value(); }
  /// Whether the surface is there at barycentrics (u, v) of a triangle.
  bool isOpaqueAt(std::uint32_t triangle, float u, float v) const;

  Bounds3 bounds() const final { return bounds_; }
  float area() const final { return static_cast<float>(area_); }
  DirectionCone normals() const final;
  const TriangleMesh* mesh() const final { return this; }
  bool canSample() const final { return area_ > 0; }
  SurfaceInteraction interaction(const Ray& ray, const ShapeHit& hit) const final;
  SurfaceInteraction interactionWithoutDerivatives(const Ray& ray, const ShapeHit& hit) const final;
  ShapeSample sampleArea(Vec2 u) const final;

 private:
  struct Corners {
    Vec3 p0, p1, p2;
  };
  Corners corners(std::uint32_t triangle) const;
  std::array<Vec2, 3> triangleUvs(std::uint32_t triangle) const;
  Vec2 uvAt(std::uint32_t triangle, float u, float v) const;
  SurfaceDerivatives derivatives(std::uint32_t triangle, const Vec3& n) const;
  Vec3 interpolated(const std::vector<Vec3>& values, const ShapeHit& hit) const;
  Vec3 shadingNormal(const ShapeHit& hit, const Vec3& n) const;
  void setShadingDerivatives(const ShapeHit& hit, SurfaceInteraction& si) const;
  double triangleArea(std::uint32_t triangle) const;
  void buildAreaCdf() const;

  MeshData data_;  // one padding point at the end
  bool flipsNormal_ = false;
  Vec3d sceneOrigin_{0};
  Bounds3 bounds_;
  double area_ = 0;
  mutable std::once_flag cdfBuilt_;  // most meshes emit nothing and never need it
  mutable std::vector<double> areaCdf_;
};

}  // namespace brume
