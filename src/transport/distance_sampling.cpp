// SPDX-License-Identifier: Apache-2.0
#include "transport/distance_sampling.h"

namespace brume {

EquiangularSampler::EquiangularSampler(const Ray& ray, Interval range, const Vec3& point)
    : range_(range) {
  const Vec3d toPoint = Vec3d(point) - Vec3d(ray.o), d(ray.d);
  foot_ = dot(toPoint, d) / dot(d, d);
  const double a = double{range.t0} - foot_, b = double{range.t1} - foot_;
  const double reach = std::max(std::abs(a), std::abs(b));
  distance_ = std::max(length(toPoint - d * foot_), 1e-6 * reach);
  // tan(theta_b - theta_a) without the difference of two nearly equal angles.
  angle_ = std::atan2(distance_ * (b - a), distance_ * distance_ + a * b);
}

DistanceSample EquiangularSampler::sample(float u) const {
  // x(theta_a + phi) - x(theta_a) by the addition theorem: no cancellation when phi is small.
  const double a = double{range_.t0} - foot_;
  const double phi = double{u} * angle_;
  const double denominator = distance_ * std::cos(phi) - a * std::sin(phi);
  const double step = std::sin(phi) * (distance_ * distance_ + a * a) / denominator;
  const double t = double{range_.t0} + step;
  const float clamped = std::clamp(static_cast<float>(t), range_.t0, range_.t1);
  return {clamped, pdf(clamped)};
}

float EquiangularSampler::pdf(float t) const {
  if (!(t >= range_.t0 && t <= range_.t1)) return 0;
  const double x = double{t} - foot_;
  return static_cast<float>(distance_ / (angle_ * (distance_ * distance_ + x * x)));
}

TransmittanceSampler::TransmittanceSampler(const MediumAlongRay& medium, Interval range)
    : medium_(medium), range_(range) {
  before_ = medium.depthAt(range.t0);
  inside_ = medium.depthAt(range.t1) - before_;
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    inside_[c] = std::max(0.0, inside_[c]);
    weights_[c] = double{medium.maxAlbedo()[c]} * -std::expm1(-inside_[c]);
    sum += weights_[c];
  }
  if (sum > 0)
    for (double& w : weights_) w /= sum;
}

std::optional<DistanceSample> TransmittanceSampler::sample(float u) const {
  // The channel by u, the distance in it by what is left of u.
  double rest = u;
  int channel = 0;
  while (channel < 2 && (weights_[channel] == 0 || rest >= weights_[channel]))
    rest -= weights_[channel++];
  while (weights_[channel] == 0) --channel;
  const double v = std::clamp(rest / weights_[channel], 0.0, 1.0);
  const double depth = -std::log1p(v * std::expm1(-inside_[channel]));
  const auto t = medium_.invert(channel, before_[channel] + std::min(depth, inside_[channel]));
  if (!t) return std::nullopt;
  const float clamped = std::clamp(*t, range_.t0, range_.t1);
  return DistanceSample{clamped, pdf(clamped)};
}

float TransmittanceSampler::pdf(const Rgb& sigma_t, const Vec3d& depth) const {
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    if (weights_[c] == 0) continue;
    sum += weights_[c] * double{sigma_t[c]} * std::exp(before_[c] - depth[c]) /
           -std::expm1(-inside_[c]);
  }
  return static_cast<float>(sum);
}

ScatteringDistanceSampler::ScatteringDistanceSampler(const MediumAlongRay& medium, Interval range,
                                                     const std::optional<Vec3>& lightPosition)
    : medium_(medium), transmittance_(medium, range) {
  if (lightPosition) equiangular_.emplace(medium.ray(), range, *lightPosition);
}

std::optional<ScatteringDistanceSampler::Sample> ScatteringDistanceSampler::sample(float u) const {
  float t = 0;
  if (equiangular_ && u < 0.5f) {
    t = equiangular_->sample(2 * u).t;
  } else {
    const auto chosen = transmittance_.sample(equiangular_ ? 2 * u - 1 : u);
    if (!chosen) return std::nullopt;
    t = chosen->t;
  }
  Sample s;
  s.t = t;
  s.medium = medium_.at(t);
  const Vec3d depth = medium_.depthAt(t);
  s.Tr = medium_.toTransmittance(depth);
  s.pdf = mixture(t, s.medium.sigma_t(), depth);
  if (!(s.pdf > 0)) return std::nullopt;
  return s;
}

float ScatteringDistanceSampler::pdf(float t) const {
  return mixture(t, medium_.at(t).sigma_t(), medium_.depthAt(t));
}

float ScatteringDistanceSampler::mixture(float t, const Rgb& sigma_t, const Vec3d& depth) const {
  const float collision = transmittance_.pdf(sigma_t, depth);
  return equiangular_ ? 0.5f * (collision + equiangular_->pdf(t)) : collision;
}

}  // namespace brume
