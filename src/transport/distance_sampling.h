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
  /// Angle from the start of the range to t; from 0 to angle().
  double angleTo(double t) const;
  /// Its inverse.
  double at(double angle) const;
  double angle() const { return angle_; }
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
/// which bounds the weight of scattering, sigma_s,c Tr_c / pdf <= sum_c max albedo_c <= 3.
class TransmittanceSampler {
 public:
  /// The medium outlives the sampler; range lies in its range.
  TransmittanceSampler(const MediumAlongRay& medium, Interval range);
  /// sum_c Tr_c max albedo_c (1 - Tr_c(range)), Tr up to the range.
  double strengthSeenFrom(const Rgb& Tr) const;
  /// Optical depth of the range in the densest channel.
  double depth() const { return std::max({inside_.x, inside_.y, inside_.z}); }
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

/// Estimated in-scattering of one light along a ray: what the distances are drawn by. Need not be
/// right, only near; evaluated at a few t.
class ScatteringEstimate {
 public:
  virtual ~ScatteringEstimate() = default;
  /// Light turned towards the viewer per sigma_s at ray(t), without shadows; any scale, >= 0.
  virtual float at(float t) const = 0;
  /// Close to the truth, but for shadows, and smooth in t, as is the medium.
  virtual bool isReliable() const = 0;
};

/// Distances for the light of one source. The range is cut at quantiles of equiangular and of
/// transmittance sampling. Two tables over these cuts:
/// - where the estimate is reliable and the medium thin (closed form, depth up to 16), the density
/// is linear in angle between the
///   cuts (in length for lights without position), through values proportional to
///   sigma_s Tr(0,t) estimate(t) dt/dangle, with 0.02 spread evenly;
/// - elsewhere a piece is drawn by its exact collisions times the estimate at their median,
///     P_i ~ sum_c max albedo_c (Tr_c(t_i) - Tr_c(t_i+1)) estimate,  with 0.1 by the collisions
///     alone,
///   and the distance in it by transmittance sampling, so that no detail of the density is missed;
///   weights are bounded by 10 sum_c max albedo_c times the source.
/// The distance grows with u (but for changes of channel in chromatic grids), so evenly spaced u
/// make a quadrature of the smooth quotient of integrand and density.
class ScatteringDistanceSampler {
 public:
  ScatteringDistanceSampler(const MediumAlongRay& medium, Interval range,
                            const std::optional<Vec3>& lightPosition,
                            const ScatteringEstimate& estimate);
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
  static constexpr int kQuantiles = 4;
  static constexpr int kMaxPieces = 2 * kQuantiles + 1;

  // The table is linear in a variable x(t): angle or length.
  double toX(double t) const {
    return equiangular_ ? equiangular_->angleTo(t) : t - double{range_.t0};
  }
  double fromX(double x) const {
    return equiangular_ ? equiangular_->at(x) : double{range_.t0} + x;
  }
  double xPerLength(double t) const { return equiangular_ ? equiangular_->anglePerLength(t) : 1; }

  void cutAtQuantiles();
  void tabulateDensity(const ScatteringEstimate& estimate);
  void tabulateCollisions(const ScatteringEstimate& estimate);
  std::size_t findPiece(const std::array<double, kMaxPieces + 1>& borders, double value) const;
  std::optional<float> distanceIn(std::size_t piece, double w) const;
  float pdf(float t, const Rgb& sigma_t, const Vec3d& depth) const;

  const MediumAlongRay& medium_;
  Interval range_;
  TransmittanceSampler transmittance_;
  std::optional<EquiangularSampler> equiangular_;
  bool isLinear_ = false;  // else transmittance sampling within pieces
  int pieces_ = 0;
  std::array<double, kMaxPieces + 1> x_{};        // cuts
  std::array<double, kMaxPieces + 1> density_{};  // per x, at the cuts, when linear
  std::array<float, kMaxPieces + 1> t_{};         // cuts as distances, when not
  std::array<double, kMaxPieces + 1> upTo_{};     // cumulative probability
};

}  // namespace brume
