// SPDX-License-Identifier: Apache-2.0
#include "core/coplanar_lights.h"

#include "core/light.h"
#include "core/triangle_mesh.h"

namespace brume {
namespace {

/// Surfaces nearer than this, relative to their coordinates, are in one place.
constexpr double kSlack = 1e-5;
/// Triangles times lights to be compared; beyond that all surfaces count that overlap a light.
constexpr std::size_t kMostComparisons = 20'000'000;

struct Plane {
  Vec3d p{0}, n{0};
  bool holds(const Vec3& q, double slack) const { return std::abs(dot(Vec3d(q) - p, n)) <= slack; }
};

std::array<Vec3, 3> corners(const TriangleMesh& mesh, std::uint32_t triangle) {
  const int* index = mesh.indexData() + std::size_t{3} * triangle;
  const auto point = [&](int i) { return mesh.pointData()[index[i]]; };
  return {point(0), point(1), point(2)};
}

/// A light's place: its bounds and, if it is flat, its plane.
struct Place {
  Bounds3 bounds;
  std::optional<Plane> plane;
  double slack = 0;

  explicit Place(const Shape& shape) : bounds(shape.bounds()) {
    const Vec3 largest = max(abs(bounds.lo), abs(bounds.hi));
    slack = kSlack * double{std::max(maxComponent(largest), maxComponent(bounds.diagonal()))};
    bounds.lo -= Vec3(static_cast<float>(slack));
    bounds.hi += Vec3(static_cast<float>(slack));
    const TriangleMesh* mesh = shape.mesh();
    if (!mesh) return;
    Plane found;
    for (std::uint32_t i = 0; i < mesh->triangleCount(); ++i) {
      const auto c = corners(*mesh, i);
      const Vec3d n = cross(Vec3d(c[1]) - Vec3d(c[0]), Vec3d(c[2]) - Vec3d(c[0]));
      const double l = length(n);
      if (!(l > 0)) continue;
      if (dot(found.n, found.n) == 0) found = {Vec3d(c[0]), n * (1 / l)};
      for (const Vec3& p : c)
        if (!found.holds(p, slack)) return;
    }
    plane = found;
  }
  bool overlaps(const Bounds3& b) const {
    for (int a = 0; a < 3; ++a)
      if (b.hi[a] < bounds.lo[a] || b.lo[a] > bounds.hi[a]) return false;
    return true;
  }
  /// Whether a triangle of the mesh may hold a part of the light.
  bool touches(const TriangleMesh& mesh) const {
    for (std::uint32_t i = 0; i < mesh.triangleCount(); ++i) {
      const auto c = corners(mesh, i);
      Bounds3 box;
      for (const Vec3& p : c) box.extend(p);
      if (!overlaps(box)) continue;
      if (!plane ||
          (plane->holds(c[0], slack) && plane->holds(c[1], slack) && plane->holds(c[2], slack)))
        return true;
    }
    return false;
  }
};

}  // namespace

CoplanarLights::CoplanarLights(const std::vector<Primitive>& primitives)
    : first_(primitives.data()) {
  std::vector<Place> places;
  std::vector<const Primitive*> lights;
  for (const Primitive& p : primitives)
    if (p.areaLight && !p.areaLight->power().isBlack()) {
      places.emplace_back(*p.shape);
      lights.push_back(&p);
    }
  if (lights.empty()) return;

  std::vector<bool> inLight(primitives.size()), touched(lights.size());
  std::size_t comparisons = 0;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    if (primitives[i].areaLight) continue;
    const Shape& shape = *primitives[i].shape;
    const Bounds3 bounds = shape.bounds();
    for (std::size_t k = 0; k < lights.size(); ++k) {
      if (!places[k].overlaps(bounds)) continue;
      const TriangleMesh* mesh = shape.mesh();
      if (mesh) comparisons += mesh->triangleCount();
      if (mesh && comparisons <= kMostComparisons && !places[k].touches(*mesh)) continue;
      inLight[i] = touched[k] = true;
    }
  }
  lights_.resize(1);
  for (std::size_t k = 0; k < lights.size(); ++k)
    if (touched[k]) lights_[0].primitives.push_back(*lights[k]);
  if (lights_[0].primitives.empty()) return;
  accelerator_ = buildEmbreeAccelerator(lights_);
  inLight_ = std::move(inLight);
}

std::optional<CoplanarLights::Found> CoplanarLights::at(const Ray& ray, float t,
                                                        float slack) const {
  const float from = std::max(t - slack, 0.f);
  const Vec3d start = Vec3d(ray.o) + Vec3d(ray.d) * double{from};
  const Ray around{Vec3(start), ray.d, t + slack - from, ray.time};
  const auto hit = accelerator_->intersect(around);
  if (!hit) return std::nullopt;
  return Found{around, *hit};
}

}  // namespace brume
