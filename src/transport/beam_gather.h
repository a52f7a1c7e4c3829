// SPDX-License-Identifier: Apache-2.0
// The beam radiance estimate turned round, for the common medium: each photon goes to the beams it
// is inside of, eight at a time. For phase functions that are no sum of Henyey-Greenstein lobes:
// BeamLookup::accumulate with a callback.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "accelerators/beam_quadtree.h"
#include "core/medium_along_ray.h"
#include "core/rgb.h"

namespace brume {

/// A photon with what its scattering needs.
struct BeamPhoton {
  Vec3 p{0};
  Vec3 w{0, 0, 1};  ///< unit, the direction in which it travels
  Rgb power;        ///< albedo(p) alpha [W], times the first lobe's weight
  float g = 0;      ///< of the Henyey-Greenstein phase function at p, in (-1, 1); 0: isotropic
  /// More lobes of the phase function, of an array beside: [begin, begin + count).
  std::uint32_t lobesBegin = 0, lobeCount = 0;
};

/// One more lobe of a photon's phase function.
struct BeamLobe {
  Rgb power;  ///< its weight times albedo(p) alpha [W]
  float g = 0;
};

/// What a beam received.
struct BeamSum {
  double r = 0, g = 0, b = 0;  ///< [W m^-2 sr^-1]
  std::uint64_t count = 0;     ///< of photons inside the beam

  BeamSum& operator+=(const BeamSum& o) {
    r += o.r;
    g += o.g;
    b += o.b;
    count += o.count;
    return *this;
  }
};

/// Adds to sums[b], for each beam b of the tree,
///   sum_i Tr(t0, t_i) p(w_i, -d) power_i K2(d_i; radius)     over the photons i inside (isInBeam)
///   Tr(t0, t) = exp(-sigma_t (t - t0))   from the beam's own t0, as one and the same homogeneous
///                                        medium has it; what lies before t0 is up to the caller
///   p the Henyey-Greenstein phase function of the photon's g;  K2 the DiscKernel
/// and the number of these photons. Single terms have a relative error of 1e-6; they are added in
/// the order of the photons, some thousand in float, then in double. Same bits for any number of
/// threads. Test: beam_gather_test.
void gatherHomogeneous(const BeamQuadtree& tree, std::span<const BeamPhoton> photons,
                       const Rgb& sigma_t, std::span<BeamSum> sums);

/// The same in any media: Tr(t0, t) from the media along each beam, as `mediumOf(beam, medium)`
/// fills them in, looked up once for each beam that receives photons; and with all lobes of the
/// photons.
using MediumOfBeam = std::function<void(std::uint32_t beam, MediumAlongRay& medium)>;
void gatherInMedia(const BeamQuadtree& tree, std::span<const BeamPhoton> photons,
                   std::span<const BeamLobe> lobes, const MediumOfBeam& mediumOf,
                   std::span<BeamSum> sums);

}  // namespace brume
