// SPDX-License-Identifier: Apache-2.0
// The one rule that says whether a photon counts for a beam: photon BVH and beam hierarchy share
// it, so that both find the same pairs bit for bit.
#pragma once

#include "core/math.h"

namespace brume {

/// Where a point stands beside a line: T is float, or several floats at once.
template <class T>
struct BeamFoot {
  T t;   ///< of the foot, the nearest point of the line
  T d2;  ///< squared distance between point and foot
};

/// The foot of the point p, or o + q, on the line o + t d, |d| = 1. The expression and its order
/// are fixed (and nothing is contracted to fused multiply-add), so every caller gets the same bits.
/// The distance comes from the difference of two positions, not of two squares, which would cancel
/// far from o.
template <class T>
[[gnu::always_inline]] inline BeamFoot<T> beamFoot(const T& qx, const T& qy, const T& qz,
                                                   const T& dx, const T& dy, const T& dz) {
  const T t = qx * dx + qy * dy + qz * dz;
  const T ex = qx - t * dx, ey = qy - t * dy, ez = qz - t * dz;
  return {t, ex * ex + ey * ey + ez * ez};
}
template <class T>
[[gnu::always_inline]] inline BeamFoot<T> beamFoot(const T& ox, const T& oy, const T& oz,
                                                   const T& dx, const T& dy, const T& dz,
                                                   const T& px, const T& py, const T& pz) {
  return beamFoot<T>(px - ox, py - oy, pz - oz, dx, dy, dz);
}

inline BeamFoot<float> beamFoot(const Vec3& o, const Vec3& d, const Vec3& p) {
  return beamFoot(o.x, o.y, o.z, d.x, d.y, d.z, p.x, p.y, p.z);
}

/// A photon counts when its foot lies in the closed range of the beam (so none behind the ray's end
/// does) and its distance is below the radius.
inline bool isInBeam(const BeamFoot<float>& foot, Interval range, float radius2) {
  return foot.t >= range.t0 && foot.t <= range.t1 && foot.d2 < radius2;
}

/// Positions and radii differ from their exact values by less than this part of the largest
/// coordinates involved, counted over all roundings of beamFoot (some 12 half ulps, sqrt 3 for
/// three coordinates, directions normalised to a few ulps). Bounds that exclude photons are widened
/// by it: they may then be computed in any order.
inline constexpr float kBeamSlack = 8e-6f;

}  // namespace brume
