// SPDX-License-Identifier: Apache-2.0
#include "core/interaction.h"

#include <bit>

namespace brume {

namespace {

/// The next float above x (below, for step = -1); x finite.
float nextFloat(float x, int step) {
  const auto bits = std::bit_cast<std::int32_t>(x);
  const float next = std::bit_cast<float>(bits + ((x > 0.f) == (step > 0) ? 1 : -1));
  const float nextToZero = step > 0 ? 0x1p-149f : -0x1p-149f;
  return x == 0.f ? nextToZero : next;
}

/// origin + offset, rounded away from the origin.
float movedBy(float offset, float origin) {
  const float moved = origin + offset;
  return offset == 0.f ? moved : nextFloat(moved, offset > 0.f ? 1 : -1);
}

/// Solves [a b] (x, y)^T = r for columns a, b of two rows; zero when singular.
Vec2 solve2x2(Vec2 a, Vec2 b, Vec2 r) {
  const double det = static_cast<double>(a.x) * b.y - static_cast<double>(b.x) * a.y;
  const double x = (static_cast<double>(r.x) * b.y - static_cast<double>(b.x) * r.y) / det;
  const double y = (static_cast<double>(a.x) * r.y - static_cast<double>(r.x) * a.y) / det;
  const Vec2 solution(static_cast<float>(x), static_cast<float>(y));
  return std::isfinite(solution.x) && std::isfinite(solution.y) ? solution : Vec2(0);
}

}  // namespace

Vec3 offsetRayOrigin(const Vec3& p, const Vec3& pError, const Vec3& n, const Vec3& w) {
  const float distance = dot(abs(n), pError);
  const Vec3 offset = n * (dot(w, n) < 0.f ? -distance : distance);
  return {movedBy(offset.x, p.x), movedBy(offset.y, p.y), movedBy(offset.z, p.z)};
}

Vec3 SurfaceInteraction::offsetOrigin(const Vec3& w) const {
  return offsetRayOrigin(p, pError, n, w);
}

void SurfaceInteraction::computeFootprint(const FootprintRay& ray, const Vec3& sceneOrigin) {
  texture = {};
  texture.p = p + sceneOrigin;
  texture.uv = uv;
  if (!ray.differential) return;
  const RayDifferential& rd = *ray.differential;

  // Where the neighbouring rays meet the tangent plane.
  const float tx = dot(n, p - rd.rxOrigin) / dot(n, rd.rxDirection);
  const float ty = dot(n, p - rd.ryOrigin) / dot(n, rd.ryDirection);
  const Vec3 dpdx = rd.rxOrigin - p + rd.rxDirection * tx;
  const Vec3 dpdy = rd.ryOrigin - p + rd.ryDirection * ty;
  if (!isFinite(dpdx) || !isFinite(dpdy)) return;
  texture.dpdx = dpdx;
  texture.dpdy = dpdy;

  // Three equations for two unknowns: the one of the axis nearest to the normal is left out.
  const Vec3 a = abs(n);
  const int dropped = a.x > a.y && a.x > a.z ? 0 : a.y > a.z ? 1 : 2;
  const int i = dropped == 0 ? 1 : 0, j = dropped == 2 ? 1 : 2;
  const Vec3 &du = geometry.dpdu, &dv = geometry.dpdv;
  const Vec2 u(du[i], du[j]), v(dv[i], dv[j]);
  const Vec2 dx = solve2x2(u, v, {dpdx[i], dpdx[j]}), dy = solve2x2(u, v, {dpdy[i], dpdy[j]});
  texture.dudx = dx.x;
  texture.dvdx = dx.y;
  texture.dudy = dy.x;
  texture.dvdy = dy.y;
}

}  // namespace brume
