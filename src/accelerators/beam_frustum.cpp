// SPDX-License-Identifier: Apache-2.0
#include "accelerators/beam_frustum.h"

#include <array>

#include "core/error.h"

namespace brume {
namespace {

/// A beam or a frustum: the points around the stretch c0 c1, closer than a radius that goes
/// linearly from r0 at one end to r1 at the other, between the planes perpendicular to u there.
struct Part {
  Vec3d c0, c1, u;
  double r0, r1;
  double reach;  ///< bound of |p - origin| of its points, which the rounding of a test scales with
};

Part partOf(const Beam& beam) {
  const Vec3d o(beam.o), d(beam.d);
  const double r = beam.radius;
  return {o + double{beam.t0} * d,
          o + double{beam.t1} * d,
          d,
          r,
          r,
          std::max(std::abs(beam.t0), std::abs(beam.t1)) + r};
}

Part partOf(const BeamFrustum& f) {
  if (!std::isfinite(f.s0)) return {{}, {}, {}, 0, 0, std::numeric_limits<double>::infinity()};
  const Vec3d a(f.a), u(f.u);
  const double s0 = f.s0, s1 = f.s1, r0 = f.r0 + f.k * s0, r1 = f.r0 + f.k * s1;
  return {a + s0 * u, a + s1 * u, u,
          r0,         r1,         std::max(std::abs(s0), std::abs(s1)) + std::max(r0, r1)};
}

float roundUp(double x) {
  const float f = static_cast<float>(x);
  return double{f} < x ? std::nextafter(f, kInfinity) : f;
}
float roundDown(double x) { return -roundUp(-x); }

/// Everywhere: what bounds beams too large for squares of floats.
BeamFrustum everywhere() { return {Vec3(0), Vec3(0), -kInfinity, kInfinity, kInfinity, 0}; }

/// Lengths beyond which float squares might overflow.
constexpr double kLargest = 1e18;
/// Steepest growth of a frustum's radius with distance. Steeper ones bound short, wide groups whose
/// ends say little.
constexpr double kSteepest = 2;

/// The mean direction, turned so that it follows the first one.
Vec3 meanDirection(std::span<const Part> parts) {
  Vec3d sum(0);
  for (const Part& part : parts) sum += dot(part.u, parts[0].u) < 0 ? -part.u : part.u;
  return Vec3(normalize(sum));  // at least as long as the first, whose products are >= 0
}

/// An end of a part as the frustum sees it.
struct End {
  double s, distance, radius, tilt;  ///< tilt: sine between the part's direction and the axis
};

/// The two ends of a part, the lower s first.
std::array<End, 2> endsOf(const Part& part, const Vec3d& a, const Vec3d& u) {
  const auto end = [&](const Vec3d& c, double radius, double tilt) -> End {
    const Vec3d w = c - a;
    const double s = dot(w, u);
    return {s, length(w - s * u), radius, tilt};
  };
  const double tilt = length(part.u - dot(part.u, u) * u);
  std::array<End, 2> ends{end(part.c0, part.r0, tilt), end(part.c1, part.r1, tilt)};
  if (ends[1].s < ends[0].s) std::swap(ends[0], ends[1]);
  return ends;
}

/// Growth of the radius from the near ends to the far ones.
double slopeOf(std::span<const Part> parts, const Vec3d& a, const Vec3d& u) {
  double sNear = 0, sFar = 0, widthNear = 0, widthFar = 0;
  for (const Part& part : parts) {
    const auto [low, high] = endsOf(part, a, u);
    sNear += low.s;
    sFar += high.s;
    widthNear = std::max(widthNear, low.distance + low.radius);
    widthFar = std::max(widthFar, high.distance + high.radius);
  }
  const double gap = (sFar - sNear) / static_cast<double>(parts.size());
  const double rise = widthFar - widthNear;
  return std::abs(rise) < kSteepest * gap ? rise / gap : 0;
}

/// Parts of which none is empty. A frustum holds a part when it holds the discs at its ends: the
/// distance from the axis is a convex function along the part, the frustum's radius an affine one.
BeamFrustum boundParts(std::span<const Part> parts) {
  BeamFrustum f;
  Vec3d middle(0);
  double reach = 0;
  for (const Part& part : parts) {
    middle += 0.5 * (part.c0 + part.c1);
    reach = std::max(reach, part.reach);
  }
  if (!(reach < kLargest)) return everywhere();
  f.u = meanDirection(parts);
  f.a = Vec3(middle * (1 / static_cast<double>(parts.size())));
  const Vec3d a(f.a), u(f.u);

  f.k = static_cast<float>(slopeOf(parts, a, u));
  const double k = f.k;
  double s0 = std::numeric_limits<double>::infinity(), s1 = -s0, r0 = -s0, width = 0;
  for (const Part& part : parts)
    for (const End& end : endsOf(part, a, u)) {
      // The disc at the end leans: its rim reaches sideways by up to radius, along by radius *
      // tilt.
      s0 = std::min(s0, end.s - end.radius * end.tilt);
      s1 = std::max(s1, end.s + end.radius * end.tilt);
      r0 = std::max(r0, end.distance + end.radius * (1 + std::abs(k) * end.tilt) - k * end.s);
      width = std::max(width, end.distance + end.radius);
    }

  // Room for the rounding of the parts' own tests and of this frustum's.
  const double own = std::max(std::abs(s0), std::abs(s1)) + width;
  const double slack = double{kBeamSlack} * (reach + own);
  f.s0 = roundDown(s0 - slack);
  f.s1 = roundUp(s1 + slack);
  f.r0 = roundUp(r0 + slack * (1 + std::abs(k)));
  return f;
}

/// Beams or frusta, as many as a node has, without memory of their own.
template <class T>
BeamFrustum boundAll(std::span<const T> all) {
  constexpr std::size_t kMost = 8;
  std::array<Part, kMost> parts;
  std::size_t count = 0;
  BRUME_CHECK(all.size() <= kMost);
  for (const T& one : all)
    if (!one.isEmpty()) parts[count++] = partOf(one);
  return count == 0 ? BeamFrustum{} : boundParts({parts.data(), count});
}

}  // namespace

BeamFrustum boundBeams(std::span<const Beam> beams) { return boundAll(beams); }
BeamFrustum boundFrusta(std::span<const BeamFrustum> frusta) { return boundAll(frusta); }

}  // namespace brume
