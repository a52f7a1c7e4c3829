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
/// D is raised to 1e-6 of the farthest |x|, which keeps rays through the point proper densities.
/// Source: Kulla, Fajardo 2012, rearranged so that far points lose no digits.
class EquiangularSampler {
 public:
  EquiangularSampler(const Ray& ray, Interval range, const Vec3& point);
  DistanceSample sample(float u) const;
  float pdf(float t) const;
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
/// which bounds the weight of scattering, sigma_s,c Tr_c / pdf <= sum_c max albedo_c <= 3.
class TransmittanceSampler {
 public:
  /// The medium outlives the sampler; range lies in its range.
  TransmittanceSampler(const MediumAlongRay& medium, Interval range);
  /// Nothing scatters in the range: sample() must not be called.
  bool isEmpty() const { return !(weights_[0] + weights_[1] + weights_[2] > 0); }
  std::optional<DistanceSample> sample(float u) const;
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

/// Equiangular (share 1/2, for lights with a position) and transmittance sampling as one mixture:
/// its density is that of the balance heuristic. One u drives both the choice and the distance, so
/// stratified u stratify each technique.
class ScatteringDistanceSampler {
 public:
  ScatteringDistanceSampler(const MediumAlongRay& medium, Interval range,
                            const std::optional<Vec3>& lightPosition);
  bool isEmpty() const { return transmittance_.isEmpty(); }

  struct Sample {
    float t = 0;
    float pdf = 0;
    MediumCoefficients medium;  ///< at t
    Rgb Tr;                     ///< from the start of the medium's range to t
  };
  std::optional<Sample> sample(float u) const;
  float pdf(float t) const;

 private:
  float mixture(float t, const Rgb& sigma_t, const Vec3d& depth) const;

  const MediumAlongRay& medium_;
  TransmittanceSampler transmittance_;
  std::optional<EquiangularSampler> equiangular_;
};

}  // namespace brume
