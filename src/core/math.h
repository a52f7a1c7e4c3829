// SPDX-License-Identifier: Apache-2.0
// Vectors, bounds, frames and small numeric helpers. The one place that includes GLM.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#if defined(GLM_VERSION) && !defined(GLM_FORCE_CTOR_INIT)
#error "include core/math.h before any header of GLM: its macros change how vectors are passed"
#endif
#define GLM_FORCE_CTOR_INIT
#define GLM_FORCE_XYZW_ONLY
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace brume {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Vec2d = glm::dvec2;
using Vec3d = glm::dvec3;
using Vec2i = glm::ivec2;
using Mat4 = glm::mat4;
using Mat4d = glm::dmat4;

inline constexpr float kPi = 3.14159265358979323846f;
inline constexpr float kInvPi = 1.f / kPi;
inline constexpr float kInv4Pi = 1.f / (4.f * kPi);
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// Largest float below 1: the upper end of every uniform random number.
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;
/// Half an ulp of 1: the bound on the relative error of one rounding.
inline constexpr float kMachineEpsilon = std::numeric_limits<float>::epsilon() * 0.5f;

/// Bound on the relative error of n float operations (Higham, section 3.1).
constexpr float gamma(int n) {
  const float nEpsilon = static_cast<float>(n) * kMachineEpsilon;
  return nEpsilon / (1.f - nEpsilon);
}

template <class T>
constexpr T sqr(T x) {
  return x * x;
}
template <class T>
constexpr T lerp(T a, T b, float t) {
  return (1.f - t) * a + t * b;
}
constexpr float radians(float degrees) { return degrees * (kPi / 180.f); }
inline float safeSqrt(float x) { return std::sqrt(std::max(0.f, x)); }
inline float safeAcos(float x) { return std::acos(std::clamp(x, -1.f, 1.f)); }

inline float dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline float absDot(const Vec3& a, const Vec3& b) { return std::abs(dot(a, b)); }
inline float dot(const Vec2& a, const Vec2& b) { return a.x * b.x + a.y * b.y; }
inline double dot(const Vec3d& a, const Vec3d& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
/// Cross product in double, rounded once: no cancellation for nearly parallel vectors.
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  const double ax = a.x, ay = a.y, az = a.z, bx = b.x, by = b.y, bz = b.z;
  return {static_cast<float>(ay * bz - az * by), static_cast<float>(az * bx - ax * bz),
          static_cast<float>(ax * by - ay * bx)};
}
inline Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float lengthSquared(const Vec3& v) { return dot(v, v); }
inline float length(const Vec3& v) { return std::sqrt(dot(v, v)); }
inline double length(const Vec3d& v) { return std::sqrt(dot(v, v)); }
inline Vec3 normalize(const Vec3& v) { return v * (1.f / length(v)); }
inline Vec3d normalize(const Vec3d& v) { return v * (1 / length(v)); }
/// Unit vector along v; safe for lengths whose square under- or overflows; none for the zero or a
/// non-finite vector.
inline std::optional<Vec3> tryNormalize(const Vec3& v) {
  const Vec3d d(v);
  const double l = length(d);
  if (!(l > 0) || !std::isfinite(l)) return std::nullopt;
  return Vec3(d * (1 / l));
}
inline float distance(const Vec3& a, const Vec3& b) { return length(a - b); }
inline Vec3 abs(const Vec3& v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }
inline Vec3 min(const Vec3& a, const Vec3& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
inline Vec3 max(const Vec3& a, const Vec3& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
inline float maxComponent(const Vec3& v) { return std::max(v.x, std::max(v.y, v.z)); }
inline bool isFinite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
/// n, turned to the side of v.
inline Vec3 faceForward(const Vec3& n, const Vec3& v) { return dot(n, v) < 0.f ? -n : n; }

/// Right-handed orthonormal frame around z (world space unless its user says otherwise).
struct Frame {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

  /// Frame around a unit vector. Source: Duff et al. 2017, Building an Orthonormal Basis,
  /// Revisited.
  static Frame fromZ(const Vec3& z) {
    const float sign = std::copysign(1.f, z.z);
    const float a = -1.f / (sign + z.z);
    const float b = z.x * z.y * a;
    return {Vec3(1 + sign * z.x * z.x * a, sign * b, -sign * z.x),
            Vec3(b, sign + z.y * z.y * a, -z.y), z};
  }
  Vec3 toLocal(const Vec3& v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
  Vec3 fromLocal(const Vec3& v) const { return x * v.x + y * v.y + z * v.z; }
};

/// Axis-aligned box; empty when lo > hi.
struct Bounds3 {
  Vec3 lo{kInfinity};
  Vec3 hi{-kInfinity};

  bool isEmpty() const { return lo.x > hi.x || lo.y > hi.y || lo.z > hi.z; }
  Vec3 diagonal() const { return hi - lo; }
  Vec3 center() const { return 0.5f * lo + 0.5f * hi; }
  float radius() const { return isEmpty() ? 0.f : 0.5f * length(diagonal()); }
  Vec3 corner(int i) const {
    return {i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z};
  }
  bool contains(const Vec3& p) const {
    return p.x >= lo.x && p.x <= hi.x && p.y >= lo.y && p.y <= hi.y && p.z >= lo.z && p.z <= hi.z;
  }
  void extend(const Vec3& p) {
    lo = min(lo, p);
    hi = max(hi, p);
  }
  void extend(const Bounds3& b) {
    lo = min(lo, b.lo);
    hi = max(hi, b.hi);
  }
};

/// Half-open rectangle of pixels [lo, hi) in raster space.
struct Bounds2i {
  Vec2i lo{0}, hi{0};
  int width() const { return std::max(0, hi.x - lo.x); }
  int height() const { return std::max(0, hi.y - lo.y); }
  std::int64_t area() const { return std::int64_t{width()} * height(); }
  bool contains(Vec2i p) const { return p.x >= lo.x && p.x < hi.x && p.y >= lo.y && p.y < hi.y; }
};

/// An interval [t0, t1] of ray parameters (lengths, where directions are normalised).
struct Interval {
  float t0 = 0, t1 = 0;
  float length() const { return t1 - t0; }
  bool isEmpty() const { return !(t0 < t1); }
};

}  // namespace brume
