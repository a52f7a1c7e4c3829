// SPDX-License-Identifier: Apache-2.0
// Where along a ray to look for scattered light. All densities are per length along the ray.
#pragma once

#include "core/medium_along_ray.h"

namespace brume {

struct DistanceSample {
  float t = 0;
  float pdf = 0;  ///< [1/length]
};

/// Density proportional to 1 / distance^2 from a point: uniform in the angle under which the point
/// sees the ray. With x = t - delta the offset from the point's foot on the ray and D its distance
///   pdf = D / ((theta_b - theta_a) (D^2 + x^2)),  theta = atan(x / D).
/// D is raised to 1e-6 of the farthest |x|, which keeps rays through the point proper densities,
/// and for a light of some extent to sqrt(D^2 + extent^2 / 4), about what a disk of that radius
/// gives. Source: Kulla, Fajardo 2012, rearranged so that far points lose no digits.
class EquiangularSampler {
 public:
  EquiangularSampler(const Ray& ray, Interval range, const Vec3& point, float extent = 0);
  DistanceSample sample(float u) const;
  float pdf(float t) const;
  /// Angle from the start of the range to t; from 0 to angle().
  double angleTo(double t) const;
  /// Its inverse.
  double at(double angle) const;
  double angle() const { return angle_; }
  /// Largest over smallest 1/distance^2 in the range.
  double variation() const;
  /// d angleTo / dt.
  double anglePerLength(double t) const {
    return distance_ / (distance_ * distance_ + sqr(t - foot_));
  }
  /// Int 1 / distance^2 dt over the range = (theta_b - theta_a) / D.
  float integral() const { return static_cast<float>(angle_ / distance_); }

 private:
  Interval range_;
  double foot_;      // t of the point's foot
  double distance_;  // D
  double angle_;     // theta_b - theta_a
};

/// Density of the collisions that happen inside a part of the ray, by inversion of the optical
/// depth. Chromatic media: one channel is drawn, and the density is the mean over channels,
///   pdf = sum_c w_c sigma_t,c Tr_c / (1 - Tr_c(range)),  w_c ~ max albedo_c (1 - Tr_c(range)),
/// which bounds the weight of scattering, sigma_s,c Tr_c / pdf <= sum_c max albedo_c <= 3. Grey
/// media take one channel for all, so that t grows with u.
class TransmittanceSampler {
 public:
  /// The medium outlives the sampler; range lies in its range.
  TransmittanceSampler(const MediumAlongRay& medium, Interval range);
  /// Optical depth of the range.
  const Vec3d& depth() const { return inside_; }
  /// Nothing scatters in the range: sample() must not be called.
  bool isEmpty() const { return !(weights_[0] + weights_[1] + weights_[2] > 0); }
  std::optional<DistanceSample> sample(float u) const;
  std::optional<float> distance(float u) const;
  float pdf(float t) const { return pdf(medium_.at(t).sigma_t(), medium_.depthAt(t)); }
  /// The same from sigma_t at t and the optical depth from the start of the medium's range.
  float pdf(const Rgb& sigma_t, const Vec3d& depth) const;

 private:
  const MediumAlongRay& medium_;
  Interval range_;

  Vec3d before_;       // optical depth up to the range
  Vec3d inside_;       // optical depth of the range
  double weights_[3];  // of the channels; sum 1, or all 0
};

/// Density proportional to (1 + b s)^-2 along s = t - t0, like a mean of exponentials of different
/// rates, which has no inverse in closed form:
///   s = u L / (1 + b L (1 - u)),  pdf = (1 + b L) / (L (1 + b s)^2),  L the length of the range
/// The ends' densities have the ratio (1 + b L)^2.
class FalloffSampler {
 public:
  /// growth = 1 + b L, kept between 1e-4 and 1e8.
  FalloffSampler(Interval range, double growth);
  float distance(float u) const;
  float pdf(float t) const;

 private:
  Interval range_;
  double growth_;
};

/// One point of a rule for integrals over [0, 1].
struct RulePoint {
  float u = 0;
  float weight = 1;  ///< mean over the points estimates the integral
};

/// What a function does at the ends of its interval.
enum class Ends { Vanish, Jump };

/// Point i of n evenly spaced ones with a random offset in [0, 1), v = (i + offset) / n. For smooth
/// functions that do not vanish at the ends u is moved so that the rule converges faster. Unbiased
/// for any n:
///   n = 1, or a function that vanishes smoothly   u = v
///   n = 2, 3    u = 1 - |2 v - 1|: exact for linear functions when n = 2
///   n >= 4      u = v - sin(2 pi v) / (2 pi), weight du/dv = 1 - cos(2 pi v):
///               periodic and smooth at the ends; error O(n^-3), exact for constants
/// Source: Sidi 1993 for the last.
RulePoint evenRule(int i, int n, float offset, Ends ends);

/// Distances for the light of one source, by up to two techniques:
/// - by angle: equiangular from the light, even in length for lights without position;
/// - by collisions: transmittance sampling; in coloured smooth media the falloff of the mean of
///   sigma_s Tr over channels, so that t grows with u.
/// By angle alone where the medium is smooth and sigma_s Tr varies by no more than a factor of 50
/// along the ray, else by collisions alone where 1/distance^2 varies by no more than 5, else both
/// with equal shares c = 1/2; in tracked media by angle alone. The density is that of the mixture
/// (balance heuristic, Veach 1997)
///   pdf = c p_angle + (1 - c) p_collisions
class ScatteringDistanceSampler {
 public:
  ScatteringDistanceSampler(const MediumAlongRay& medium, Interval range,
                            const std::optional<Vec3>& lightPosition, float lightExtent = 0);
  bool isEmpty() const {
    return medium_.isTracked() ? medium_.maxAlbedo().isBlack() : transmittance_.isEmpty();
  }

  enum class Technique { Angle, Collisions };
  float share(Technique t) const { return t == Technique::Angle ? angleShare_ : 1 - angleShare_; }

  struct Sample {
    float t = 0;
    float pdf = 0;              ///< of the mixture
    MediumCoefficients medium;  ///< at t
    Rgb Tr;                     ///< from the start of the medium's range to t
  };
  /// Of one technique; t grows with u (but for changes of channel in coloured grids).
  std::optional<Sample> sample(Technique technique, float u) const;
  /// Of the mixture.
  std::optional<Sample> sample(float u) const;
  float pdf(float t) const { return pdf(t, medium_.at(t).sigma_t(), medium_.depthAt(t)); }

 private:
  void chooseTechniques(const std::optional<Vec3>& lightPosition, float lightExtent);
  float pdf(float t, const Rgb& sigma_t, const Vec3d& depth) const;

  const MediumAlongRay& medium_;
  Interval range_;
  TransmittanceSampler transmittance_;
  std::optional<EquiangularSampler> equiangular_;
  std::optional<FalloffSampler> falloff_;  // instead of transmittance_
  float angleShare_ = 1;
};

}  // namespace brume
