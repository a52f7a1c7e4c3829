// SPDX-License-Identifier: Apache-2.0
#include "transport/distance_sampling.h"

namespace brume {

namespace {

/// Variation of sigma_s Tr over the range up to which angles alone do: a smooth factor is left to
/// the quadrature, because two techniques halve the points of each.
constexpr double kSmallAttenuation = 50;
/// Variation of 1/distance^2 up to which collisions alone do.
constexpr double kSmallFalloff = 5;

}  // namespace

EquiangularSampler::EquiangularSampler(const Ray& ray, Interval range, const Vec3& point,
                                       float extent)
    : range_(range) {
  const Vec3d toPoint = Vec3d(point) - Vec3d(ray.o), d(ray.d);
  foot_ = dot(toPoint, d) / dot(d, d);
  const double a = double{range.t0} - foot_, b = double{range.t1} - foot_;
  const double reach = std::max(std::abs(a), std::abs(b));
  const Vec3d across = toPoint - d * foot_;
  distance_ = std::max(std::sqrt(dot(across, across) + 0.25 * sqr(double{extent})), 1e-6 * reach);
  // tan(theta_b - theta_a) without the difference of two nearly equal angles.
  angle_ = std::atan2(distance_ * (b - a), distance_ * distance_ + a * b);
}

double EquiangularSampler::angleTo(double t) const {
  const double a = double{range_.t0} - foot_, x = t - foot_;
  return std::atan2(distance_ * (x - a), distance_ * distance_ + a * x);
}

double EquiangularSampler::variation() const {
  const double a = double{range_.t0} - foot_, b = double{range_.t1} - foot_;
  const double nearest = a > 0 ? a : b < 0 ? b : 0;
  const double farthest = std::max(std::abs(a), std::abs(b));
  return (sqr(distance_) + sqr(farthest)) / (sqr(distance_) + sqr(nearest));
}

double EquiangularSampler::at(double angle) const {
  // x(theta_a + angle) - x(theta_a) by the addition theorem: no cancellation when it is small.
  const double a = double{range_.t0} - foot_;
  const double sine = std::sin(angle);
  const double step =
      sine * (distance_ * distance_ + a * a) / (distance_ * std::cos(angle) - a * sine);
  return double{range_.t0} + step;
}

DistanceSample EquiangularSampler::sample(float u) const {
  const auto t = static_cast<float>(at(double{u} * angle_));
  const float clamped = std::clamp(t, range_.t0, range_.t1);
  return {clamped, pdf(clamped)};
}

float EquiangularSampler::pdf(float t) const {
  if (!(t >= range_.t0 && t <= range_.t1)) return 0;
  return static_cast<float>(anglePerLength(double{t}) / angle_);
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
  if (!(sum > 0)) return;
  if (medium.isGrey()) {
    const auto most = std::max_element(weights_, weights_ + 3);
    std::fill(weights_, weights_ + 3, 0.0);
    *most = 1;
  } else {
    for (double& w : weights_) w /= sum;
  }
}

std::optional<DistanceSample> TransmittanceSampler::sample(float u) const {
  const auto t = distance(u);
  return t ? std::optional<DistanceSample>({*t, pdf(*t)}) : std::nullopt;
}

std::optional<float> TransmittanceSampler::distance(float u) const {
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
  return std::clamp(static_cast<float>(*t), range_.t0, range_.t1);
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

FalloffSampler::FalloffSampler(Interval range, double growth)
    : range_(range), growth_(growth > 1e-4 ? std::min(growth, 1e8) : 1e-4) {}

float FalloffSampler::distance(float u) const {
  const double s = double{u} * double{range_.length()} / (double{u} + growth_ * (1 - double{u}));
  return std::clamp(static_cast<float>(double{range_.t0} + s), range_.t0, range_.t1);
}

float FalloffSampler::pdf(float t) const {
  const double length = double{range_.length()}, s = double{t} - double{range_.t0};
  return static_cast<float>(growth_ / (length * sqr(1 + (growth_ - 1) * (s / length))));
}

RulePoint evenRule(int i, int n, float offset, Ends ends) {
  const float v = (static_cast<float>(i) + offset) / static_cast<float>(n);
  if (n == 1 || ends == Ends::Vanish) return {std::min(v, kOneMinusEpsilon), 1};
  if (n < 4) return {std::min(1 - std::abs(2 * v - 1), kOneMinusEpsilon), 1};
  const float angle = 2 * kPi * v;
  const float u = v - std::sin(angle) * (kInvPi / 2);
  return {std::clamp(u, 0.f, kOneMinusEpsilon), 1 - std::cos(angle)};
}

ScatteringDistanceSampler::ScatteringDistanceSampler(const MediumAlongRay& medium, Interval range,
                                                     const std::optional<Vec3>& lightPosition,
                                                     float lightExtent)
    : medium_(medium),
      range_{std::max(range.t0, medium.occupied().t0), std::min(range.t1, medium.occupied().t1)},
      transmittance_(medium, range_) {
  if (!isEmpty()) chooseTechniques(lightPosition, lightExtent);
}

void ScatteringDistanceSampler::chooseTechniques(const std::optional<Vec3>& lightPosition,
                                                 float lightExtent) {
  if (lightPosition) equiangular_.emplace(medium_.ray(), range_, *lightPosition, lightExtent);
  if (medium_.isTracked()) return;  // by angle: what else there is depends on the process

  // How much sigma_s Tr varies from end to end, in the worst channel.
  double variation = 1;
  if (medium_.isSmooth()) {
    const Rgb first = medium_.at(range_.t0).sigma_s, last = medium_.at(range_.t1).sigma_s;
    double sumFirst = 0, sumLast = 0, sumDepth = 0;
    for (int c = 0; c < 3; ++c) {
      if (first[c] == 0 && last[c] == 0) continue;
      const double attenuated = double{last[c]} * std::exp(-transmittance_.depth()[c]);
      const double r = attenuated / double{first[c]};
      variation = std::max({variation, r, 1 / r});
      sumFirst += double{first[c]};
      sumDepth += double{first[c]} * transmittance_.depth()[c];
      sumLast += attenuated;
    }
    // The falloff's slope at the start or its ratio of the ends, whatever makes it flatter.
    if (!medium_.isGrey())
      falloff_.emplace(range_,
                       std::min(1 + 0.5 * sumDepth / sumFirst, std::sqrt(sumFirst / sumLast)));
  }
  const bool anglesDo = medium_.isSmooth() && variation <= kSmallAttenuation;
  const bool collisionsDo = !equiangular_ || equiangular_->variation() <= kSmallFalloff;
  angleShare_ = anglesDo ? 1 : collisionsDo ? 0 : 0.5f;
}

std::optional<ScatteringDistanceSampler::Sample> ScatteringDistanceSampler::sample(
    Technique technique, float u) const {
  Sample s;
  if (technique == Technique::Angle) {
    const double t = equiangular_ ? equiangular_->at(double{u} * equiangular_->angle())
                                  : double{range_.t0} + double{u} * double{range_.length()};
    s.t = std::clamp(static_cast<float>(t), range_.t0, range_.t1);
  } else if (falloff_) {
    s.t = falloff_->distance(u);
  } else {
    const auto t = transmittance_.distance(u);
    if (!t) return std::nullopt;
    s.t = *t;
  }
  s.medium = medium_.at(s.t);
  const Vec3d depth = medium_.depthAt(s.t);
  s.Tr = MediumAlongRay::toTransmittance(depth);
  s.pdf = pdf(s.t, s.medium.sigma_t(), depth);
  if (!(s.pdf > 0)) return std::nullopt;
  return s;
}

std::optional<ScatteringDistanceSampler::Sample> ScatteringDistanceSampler::sample(float u) const {
  if (u < angleShare_) return sample(Technique::Angle, u / angleShare_);
  return sample(Technique::Collisions,
                std::min((u - angleShare_) / (1 - angleShare_), kOneMinusEpsilon));
}

float ScatteringDistanceSampler::pdf(float t, const Rgb& sigma_t, const Vec3d& depth) const {
  if (!(t >= range_.t0 && t <= range_.t1)) return 0;
  float sum = 0;
  if (angleShare_ > 0)
    sum += angleShare_ * (equiangular_ ? equiangular_->pdf(t) : 1 / range_.length());
  if (angleShare_ < 1)
    sum += (1 - angleShare_) * (falloff_ ? falloff_->pdf(t) : transmittance_.pdf(sigma_t, depth));
  return sum;
}

}  // namespace brume
