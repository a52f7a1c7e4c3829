// SPDX-License-Identifier: Apache-2.0
// Indexed triangles with optional per-vertex normals, tangents and uv, shared by all shapes that
// are made of triangles.
#pragma once

#include "core/shape.h"

namespace brume {

/// Raw data of a mesh in object space; checkMesh and the TriangleMesh constructor do the rest.
struct MeshData {
  std::vector<int> indices;  ///< 3 per triangle, each in [0, points.size())
  std::vector<Vec3> points;
  std::vector<Vec3> normals;       ///< empty or one per point
  std::vector<Vec3> tangents;      ///< empty or one per point
  std::vector<float> uvs;          ///< empty or two per point
  std::optional<FloatSlot> alpha;  ///< cut where it is exactly 0
  bool discardDegenerateUvs = false;
};

/// Triangles in shape space. Sampling is uniform by area (area CDF over triangles).
class TriangleMesh final : public Shape {
 public:
  /// Takes over the data and transforms it by context.objectToShape.
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

  Bounds3 bounds() const override { return bounds_; }
  float area() const override { return area_; }
  const TriangleMesh* mesh() const override { return this; }
  SurfaceInteraction interaction(const Ray& ray, const ShapeHit& hit) const override;
  ShapeSample sampleArea(Vec2 u) const override;

 private:
  std::array<Vec2, 3> triangleUvs(std::uint32_t triangle) const;

  MeshData data_;  // one padding point at the end
  bool flipsNormal_ = false;
  Bounds3 bounds_;
  float area_ = 0;
  std::vector<double> areaCdf_;  // built only when asked to sample
};

}  // namespace brume
