// SPDX-License-Identifier: Apache-2.0
// What the photons in media scatter towards a viewer: along a ray, and at a point.
// Henyey-Greenstein media, which is nearly all, are evaluated eight photons at a time.
#pragma once

#include "accelerators/photon_ball.h"
#include "accelerators/photon_bvh.h"
#include "core/medium_along_ray.h"
#include "transport/volume_photon_map.h"

namespace brume {

struct BeamEstimate {
  Rgb L;
  std::uint64_t photons = 0;
};

/// Beam radiance estimate along the whole range of a medium: all photons whose disc the ray
/// crosses,
///   Lv = sum_i Tr(t0, t_i) f_p(w_i, w) albedo(x_i) alpha_i K2(d_i; r_i)      [W m^-2 sr^-1]
/// The map holds scattered powers. Source: Jarosz, Zwicker, Jensen 2008. Test:
/// photon_estimates_test.
BeamEstimate beamRadiance(const VolumePhotonMap& map, const PhotonBvh& bvh,
                          const MediumAlongRay& medium);

/// How the photons around a point are chosen.
struct PointLookup {
  std::size_t nearest = 0;   ///< k; 0: all within radius
  float radius = kInfinity;  ///< of the lookup; with k: the largest
  /// Only photons between these two planes count, at these distances from the point along -wo; for
  /// what they cut off the ball the kernel is scaled up.
  Interval between{-kInfinity, kInfinity};
};

/// In-scattered light at a point per sigma_t, by the photons around it,
///   sum_{i in N(p)} f_p(w_i, w) alpha_i K3(d_i; r)                           [W m^-3 sr^-1]
/// k nearest: r is the distance to the k-th, which does not count itself, so that the density is
/// unbiased where it is even; fewer than k within the radius: all of them, with the radius. The map
/// holds arriving powers. Test: photon_estimates_test.
BeamEstimate pointRadiance(const VolumePhotonMap& map, const PointLookup& lookup, const Vec3& p,
                           const Vec3& wo, BallSearch& search);

}  // namespace brume
