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
/// The same through a volume with proportions() (Volume), which is looked up no farther than the
/// flight goes.
FreeFlight sampleFreeFlight(const Volume& volume, const Ray& ray, Interval range,
                            const Rgb& channels, float uChannel, float uDepth);

/// The same through a uniform medium in a box, whose ends are looked for only when they are needed.
class UniformFlights {
 public:
  /// None: the volume is something else.
  static std::optional<UniformFlights> through(const Volume& volume);

  const MediumCoefficients& coefficients() const { return medium_.coefficients; }
  struct Flight {
    Interval range;  ///< to the collision, or to the end of the medium
    bool collides = false;
    Rgb channels;
  };
  enum class Start { Anywhere, InMedium };
  /// None: the ray, whose end does not matter, misses the medium. `power` is what it carries.
  std::optional<Flight> sample(const Ray& ray, Start start, const Rgb& power, Vec2 u) const;
  /// Weight of a flight that ends in its collision, or goes on to t, or leaves the medium before.
  Rgb weightAtCollision(const Flight& flight) const;
  Rgb weightAt(const Flight& flight, float t) const;

 private:
  UniformFlights(const UniformMedium& medium, const MediumBox& box);
  bool contains(const Vec3d& p) const;
  Rgb relativeTr(float way) const;
  std::optional<Interval> clip(const Ray& ray) const;

  UniformMedium medium_;
  Rgb sigma_t_;
  bool isGrey_;
  Vec3d perSigma_;  // 1 / sigma_t
  Rgb excess_;      // sigma_t over that of the least channel
  std::array<Vec3d, 3> axes_;
  std::array<double, 3> lo_, hi_;  // of dot(axis, p)
};

}  // namespace brume
