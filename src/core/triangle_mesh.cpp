// SPDX-License-Identifier: Apache-2.0
#include "core/triangle_mesh.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/log.h"
#include "core/sampling.h"

namespace brume {

namespace {

/// Embree drops what lies beyond this.
constexpr double kLargestCoordinate = 1.8e18;

void checkCount(std::size_t count, std::size_t points, const char* what,
                const SourceLocation& where) {
  if (count != 0 && count != points)
    throw SceneError(
        where, fmt::format("{} {} for {} points: one per point is needed", count, what, points));
}

void checkMesh(const MeshData& data, const SourceLocation& where) {
  const std::size_t points = data.points.size();
  if (data.indices.empty()) throw SceneError(where, "the mesh has no indices");
  if (points == 0) throw SceneError(where, "the mesh has no points");
  if (data.indices.size() % 3 != 0)
    throw SceneError(where, fmt::format("{} indices are not a multiple of 3", data.indices.size()));
  checkCount(data.normals.size(), points, "normals", where);
  checkCount(data.tangents.size(), points, "tangents", where);
  checkCount(data.uvs.size() / 2, points, "uv pairs", where);
  for (std::size_t i = 0; i < data.indices.size(); ++i)
    if (data.indices[i] < 0 || static_cast<std::size_t>(data.indices[i]) >= points)
      throw SceneError(where,
                       fmt::format("index {} (number {}) is out of range: there are {} points",
                                   data.indices[i], i, points));
}

/// Whether a triangle that is not degenerate itself has two corners with equal uv.
bool hasDegenerateUvs(const MeshData& data) {
  const auto uv = [&](int i) { return Vec2(data.uvs[2 * i], data.uvs[2 * i + 1]); };
  for (std::size_t i = 0; i < data.indices.size(); i += 3) {
    const int a = data.indices[i], b = data.indices[i + 1], c = data.indices[i + 2];
    const Vec3 edge1 = data.points[b] - data.points[a], edge2 = data.points[c] - data.points[a];
    if (cross(edge1, edge2) == Vec3(0)) continue;
    if (uv(a) == uv(b) || uv(b) == uv(c) || uv(c) == uv(a)) return true;
  }
  return false;
}

/// In double: the translation of a distant scene must not be rounded before it is added.
void transformMesh(MeshData& data, const Transform& t, const SourceLocation& where) {
  const Mat4d& m = t.matrix();
  const Mat4d& inverse = t.inverseMatrix();
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    const Vec3d p(m * glm::dvec4(Vec3d(data.points[i]), 1));
    for (int k = 0; k < 3; ++k)
      if (!(std::abs(p[k]) <= kLargestCoordinate))
        throw SceneError(where, fmt::format("point number {} lies at ({}, {}, {}) after its "
                                            "transform: coordinates must stay below {:g}",
                                            i, p.x, p.y, p.z, kLargestCoordinate));
    data.points[i] = Vec3(p);
  }
  for (Vec3& n : data.normals) {
    const Vec3d d(n);
    n = Vec3(
        Vec3d(dot(Vec3d(inverse[0]), d), dot(Vec3d(inverse[1]), d), dot(Vec3d(inverse[2]), d)));
  }
  for (Vec3& s : data.tangents) s = Vec3(m * glm::dvec4(Vec3d(s), 0));
}

/// A triangle's plane in double.
struct Plane {
  Vec3d p0, edge1, edge2;
  Vec3d n{0};                    // unit, by the winding; 0 for a degenerate triangle
  double inverseDoubleArea = 0;  // 0 for a degenerate triangle

  Plane(const Vec3& a, const Vec3& b, const Vec3& c)
      : p0(a), edge1(Vec3d(b) - p0), edge2(Vec3d(c) - p0) {
    const Vec3d unscaledNormal = cross(edge1, edge2);
    const double doubleArea = length(unscaledNormal);
    if (!(doubleArea > 0)) return;
    inverseDoubleArea = 1 / doubleArea;
    n = unscaledNormal * inverseDoubleArea;
  }
  bool isDegenerate() const { return inverseDoubleArea == 0; }
  Vec3 point(float u, float v) const {
    return Vec3(p0 + edge1 * static_cast<double>(u) + edge2 * static_cast<double>(v));
  }
};

/// Bound on the error of a point on a triangle: its rounding to float, and how far Embree's float
/// arithmetic may take the plane from where it is. That measures from a vertex to the ray's origin
/// along the normal, so it is wrong by some roundings of the edges (first term), and by the
/// rounding of the normal, which a cross product of long edges makes large for slivers (second
/// term).
Vec3 pointError(const Vec3& p, const Plane& plane) {
  constexpr double kEpsilon = kMachineEpsilon;
  const Vec3d a = glm::abs(plane.edge1), b = glm::abs(plane.edge2);
  const Vec3d extent = glm::max(glm::max(a, b), glm::abs(plane.edge1 - plane.edge2));
  const Vec3d crossTerms(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x);
  const double tilt = 2 * kEpsilon * dot(crossTerms, extent) * plane.inverseDoubleArea;
  return Vec3(kEpsilon * (1.01 * glm::abs(Vec3d(p)) + 4.0 * extent) + tilt * glm::abs(plane.n) +
              Vec3d(std::numeric_limits<float>::min()));
}

}  // namespace

TriangleMesh::TriangleMesh(MeshData data, const FactoryContext& context)
    : data_(std::move(data)),
      flipsNormal_(context.flipsNormal()),
      sceneOrigin_(context.sceneOrigin) {
  checkMesh(data_, context.where);
  if (data_.discardDegenerateUvs && !data_.uvs.empty() && !data_.normals.empty() &&
      hasDegenerateUvs(data_)) {
    if (context.log) context.log->warning(context.where, "degenerate uv: all uv are discarded");
    data_.uvs = {};
  }
  // A constant alpha other than 0 cuts nothing.
  if (data_.alpha && data_.alpha->isConstant() && data_.alpha->constant != 0.f) data_.alpha.reset();

  transformMesh(data_, context.objectToShape, context.where);
  for (std::uint32_t i = 0; i < triangleCount(); ++i) {
    const Corners c = corners(i);
    bounds_.extend(c.p0);
    bounds_.extend(c.p1);
    bounds_.extend(c.p2);
    area_ += triangleArea(i);
  }
  // Embree reads the last point with a load of 16 bytes.
  data_.points.reserve(data_.points.size() + 1);
  data_.points.push_back(Vec3(0));
}

TriangleMesh::Corners TriangleMesh::corners(std::uint32_t triangle) const {
  const int* i = &data_.indices[3 * std::size_t{triangle}];
  return {data_.points[i[0]], data_.points[i[1]], data_.points[i[2]]};
}

DirectionCone TriangleMesh::normals() const {
  std::optional<DirectionCone> cone;
  for (std::uint32_t i = 0; i < triangleCount() && !(cone && cone->isEverything()); ++i) {
    const Corners c = corners(i);
    const Plane plane(c.p0, c.p1, c.p2);
    if (plane.isDegenerate()) continue;
    const auto own = DirectionCone::around(Vec3(flipsNormal_ ? -plane.n : plane.n));
    cone = cone ? unionOf(*cone, own) : own;
  }
  return cone.value_or(DirectionCone());
}

double TriangleMesh::triangleArea(std::uint32_t triangle) const {
  const Corners c = corners(triangle);
  return 0.5 * length(cross(Vec3d(c.p1) - Vec3d(c.p0), Vec3d(c.p2) - Vec3d(c.p0)));
}

std::array<Vec2, 3> TriangleMesh::triangleUvs(std::uint32_t triangle) const {
  if (data_.uvs.empty()) return {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1)};
  const int* i = &data_.indices[3 * std::size_t{triangle}];
  const auto uv = [&](int k) {
    return Vec2(data_.uvs[2 * std::size_t(k)], data_.uvs[2 * std::size_t(k) + 1]);
  };
  return {uv(i[0]), uv(i[1]), uv(i[2])};
}

Vec2 TriangleMesh::uvAt(std::uint32_t triangle, float u, float v) const {
  const std::array<Vec2, 3> uv = triangleUvs(triangle);
  return uv[0] * (1 - u - v) + uv[1] * u + uv[2] * v;
}

bool TriangleMesh::isOpaqueAt(std::uint32_t triangle, float u, float v) const {
  if (!data_.alpha) return true;
  if (data_.alpha->isConstant()) return false;  // the constructor keeps only 0
  const Corners c = corners(triangle);
  TextureContext at;
  at.p = Vec3(Vec3d(c.p0 * (1 - u - v) + c.p1 * u + c.p2 * v) + sceneOrigin_);
  at.uv = uvAt(triangle, u, v);
  return data_.alpha->evaluate(at) != 0.f;
}

/// dp/du and dp/dv from the corners' uv; any frame around n where those are degenerate.
SurfaceDerivatives TriangleMesh::derivatives(std::uint32_t triangle, const Vec3& n) const {
  const Corners c = corners(triangle);
  const std::array<Vec2, 3> uv = triangleUvs(triangle);
  const double du1 = double{uv[0].x} - uv[2].x, du2 = double{uv[1].x} - uv[2].x;
  const double dv1 = double{uv[0].y} - uv[2].y, dv2 = double{uv[1].y} - uv[2].y;
  const Vec3d dp1 = Vec3d(c.p0) - Vec3d(c.p2), dp2 = Vec3d(c.p1) - Vec3d(c.p2);
  const double determinant = du1 * dv2 - dv1 * du2;
  SurfaceDerivatives result;
  const double inverse = 1 / determinant;
  result.dpdu = Vec3((dp1 * dv2 - dp2 * dv1) * inverse);
  result.dpdv = Vec3((dp2 * du1 - dp1 * du2) * inverse);
  if (determinant == 0 || !isFinite(result.dpdu) || !isFinite(result.dpdv)) {
    const Frame frame = Frame::fromZ(n);
    result.dpdu = frame.x;
    result.dpdv = frame.y;
  }
  return result;
}

SurfaceInteraction TriangleMesh::interactionWithoutDerivatives(const Ray& ray,
                                                               const ShapeHit& hit) const {
  const Corners c = corners(hit.primitive);
  const Plane plane(c.p0, c.p1, c.p2);

  SurfaceInteraction si;
  si.p = plane.point(hit.u, hit.v);
  si.pError = pointError(si.p, plane);
  if (plane.isDegenerate())
    si.n = tryNormalize(-ray.d).value_or(Vec3(0, 0, 1));
  else
    si.n = Vec3(flipsNormal_ ? -plane.n : plane.n);
  si.uv = uvAt(hit.primitive, hit.u, hit.v);
  si.ns = data_.normals.empty() ? si.n : shadingNormal(hit, si.n);
  return si;
}

SurfaceInteraction TriangleMesh::interaction(const Ray& ray, const ShapeHit& hit) const {
  SurfaceInteraction si = interactionWithoutDerivatives(ray, hit);
  si.geometry = derivatives(hit.primitive, si.n);
  si.shading = si.geometry;
  if (!data_.normals.empty() || !data_.tangents.empty()) setShadingDerivatives(hit, si);
  return si;
}

Vec3 TriangleMesh::interpolated(const std::vector<Vec3>& values, const ShapeHit& hit) const {
  const int* i = &data_.indices[3 * std::size_t{hit.primitive}];
  return values[i[0]] * (1 - hit.u - hit.v) + values[i[1]] * hit.u + values[i[2]] * hit.v;
}

/// As in PBRT-v2 flipped with ReverseOrientation and mirroring, whatever the side of n.
Vec3 TriangleMesh::shadingNormal(const ShapeHit& hit, const Vec3& n) const {
  const std::optional<Vec3> ns = tryNormalize(interpolated(data_.normals, hit));
  if (!ns) return n;
  return flipsNormal_ ? -*ns : *ns;
}

/// Tangents and the change of the shading normal from the vertices' normals and tangents. As in
/// PBRT-v2 the tangents are unit vectors of which the first points against dpdu.
void TriangleMesh::setShadingDerivatives(const ShapeHit& hit, SurfaceInteraction& si) const {
  const Vec3 normalSum = data_.normals.empty() ? Vec3(0) : interpolated(data_.normals, hit);
  const double sumLength = length(Vec3d(normalSum));
  const bool flips = flipsNormal_ && sumLength > 0;
  const Vec3 ns = flips ? -si.ns : si.ns;  // as interpolated

  Vec3 along = si.geometry.dpdu;
  if (!data_.tangents.empty()) along = interpolated(data_.tangents, hit);
  const Vec3 tangent = tryNormalize(along).value_or(Vec3(0));
  if (const std::optional<Vec3> bitangent = tryNormalize(cross(tangent, ns))) {
    si.shading.dpdu = cross(*bitangent, ns);
    si.shading.dpdv = *bitangent;
  } else {
    const Frame frame = Frame::fromZ(ns);
    si.shading.dpdu = frame.x;
    si.shading.dpdv = frame.y;
  }
  if (!(sumLength > 0)) return;

  // The derivative of the normalised sum, across the uv of the triangle.
  const int* i = &data_.indices[3 * std::size_t{hit.primitive}];
  const std::array<Vec2, 3> uv = triangleUvs(hit.primitive);
  const double du1 = double{uv[0].x} - uv[2].x, du2 = double{uv[1].x} - uv[2].x;
  const double dv1 = double{uv[0].y} - uv[2].y, dv2 = double{uv[1].y} - uv[2].y;
  const double determinant = du1 * dv2 - dv1 * du2;
  const Vec3d n(ns), dn1 = Vec3d(data_.normals[i[0]]) - Vec3d(data_.normals[i[2]]),
                     dn2 = Vec3d(data_.normals[i[1]]) - Vec3d(data_.normals[i[2]]);
  const auto projected = [&](const Vec3d& d) {
    const Vec3 result((d - n * dot(n, d)) * ((flips ? -1 : 1) / (determinant * sumLength)));
    return isFinite(result) ? result : Vec3(0);
  };
  si.shading.dndu = projected(dn1 * dv2 - dn2 * dv1);
  si.shading.dndv = projected(dn2 * du1 - dn1 * du2);
}

void TriangleMesh::buildAreaCdf() const {
  areaCdf_.reserve(triangleCount());
  double sum = 0;
  for (std::uint32_t i = 0; i < triangleCount(); ++i) areaCdf_.push_back(sum += triangleArea(i));
}

ShapeSample TriangleMesh::sampleArea(Vec2 u) const {
  std::call_once(cdfBuilt_, [this] { buildAreaCdf(); });

  // Choose a triangle by its area, then use the rest of the random number again.
  const double target = static_cast<double>(u.x) * areaCdf_.back();
  auto chosen = std::upper_bound(areaCdf_.begin(), areaCdf_.end(), target);
  if (chosen == areaCdf_.end()) --chosen;
  const double below = chosen == areaCdf_.begin() ? 0 : *(chosen - 1);
  const double rest = *chosen > below ? (target - below) / (*chosen - below) : 0;
  const auto triangle = static_cast<std::uint32_t>(chosen - areaCdf_.begin());
  const Vec2 b = sampleUniformTriangle({std::min(static_cast<float>(rest), kOneMinusEpsilon), u.y});

  const Corners c = corners(triangle);
  const Plane plane(c.p0, c.p1, c.p2);
  ShapeSample sample;
  const float b1 = b.y, b2 = std::max(0.f, 1 - b.x - b.y);
  sample.p = plane.point(b1, b2);
  sample.pError = pointError(sample.p, plane);
  if (!plane.isDegenerate()) sample.n = Vec3(flipsNormal_ ? -plane.n : plane.n);
  sample.pdf = static_cast<float>(1 / area_);
  return sample;
}

}  // namespace brume
