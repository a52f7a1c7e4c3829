// SPDX-License-Identifier: Apache-2.0
// Free flights through media: where the next collision happens.
#pragma once

#include <array>

#include "core/medium_along_ray.h"
#include "transport/path_wave.h"

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
/// The same through a volume with proportions() (Volume), which is looked up no farther than the
/// flight goes.
FreeFlight sampleFreeFlight(const Volume& volume, const Ray& ray, Interval range,
                            const Rgb& channels, float uChannel, float uDepth);

/// The same through a uniform medium in a box, of many paths at once.
class UniformFlights {
 public:
  /// None: the volume is something else.
  static std::optional<UniformFlights> through(const Volume& volume);

  const MediumCoefficients& coefficients() const { return medium_.coefficients; }
  /// Flies as if there were no surfaces, by the numbers uChannel, uDepth: sets t, mediaFrom,
  /// mediaTo and channels.
  void sample(PathWave& wave) const;
  /// Multiplies the powers of the paths that collide by the weights of their flights.
  void weighCollisions(PathWave& wave) const;
  /// Weight of a flight that was to go farther but ends at t, or leaves the medium before.
  Rgb weightAt(float t, const PathWave& wave, std::size_t path) const;

  /// What the loops over paths need.
  struct Box {
    Rgb sigma_t, excess;  ///< excess: over the least channel
    bool isGrey = true;
    Vec3d perSigma{0};  ///< 1 / sigma_t
    std::array<Vec3d, 3> axes;
    std::array<double, 3> lo, hi;  ///< of dot(axis, p)
  };

 private:
  UniformFlights(const UniformMedium& medium, const MediumBox& box);

  UniformMedium medium_;
  Box box_;
};

}  // namespace brume
