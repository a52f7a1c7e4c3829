// SPDX-License-Identifier: Apache-2.0
// Free flights through media: where the next collision happens.
#pragma once

#include "core/medium_along_ray.h"

namespace brume {

/// sigma_s / sigma_t per channel, 0 where nothing collides.
Rgb albedoOf(const MediumCoefficients& c);

/// A free flight along a stretch of a ray: it ends in a collision, or leaves the stretch.
struct FreeFlight {
  std::optional<float> t;  ///< of the collision; none: the stretch is left behind
  /// sigma_t Tr / pdf at a collision, Tr / probability behind: the mean over the channels stays 1
  /// where the media are grey.
  Rgb weight{1.f};
};

/// Probability of each channel to draw the distance for light that carries `power`: its share.
Rgb flightChannels(const Rgb& power);

/// Draws the distance by one channel's optical depth and divides by the mean of the channels'
/// densities (balance heuristic), so that no weight exceeds 1 / (share of its channel).
///   pdf(t) = sum_c channels_c sigma_t,c(t) Tr_c(t)                          [1/length]
/// Both numbers have 24 bits; together they draw the depth with 48. Test: free_flight_test.
FreeFlight sampleFreeFlight(const MediumAlongRay& medium, const Rgb& channels, float uChannel,
                            float uDepth);
/// The same through a uniform medium that fills the range.
FreeFlight sampleFreeFlight(const UniformMedium& medium, Interval range, const Rgb& channels,
                            float uChannel, float uDepth);
/// Weight of a flight that such a draw would have let go on, behind the first `way` of the medium.
Rgb flightPast(const UniformMedium& medium, float way, const Rgb& channels);

}  // namespace brume
