// SPDX-License-Identifier: Apache-2.0
#include "transport/distance_sampling.h"

namespace brume {

namespace {

/// Share of the pieces' probabilities that goes by their angle alone.
constexpr double kEvenShare = 0.2;
/// Share of transmittance sampling in the mixture.
constexpr float kTransmittanceShare = 0.25f;

}  // namespace

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

double EquiangularSampler::angleTo(double t) const {
  const double a = double{range_.t0} - foot_, x = t - foot_;
  return std::atan2(distance_ * (x - a), distance_ * distance_ + a * x);
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
                                                     const std::optional<Vec3>& lightPosition,
                                                     const ScatteringEstimate& estimate)
    : medium_(medium), range_(range), transmittance_(medium, range) {
  if (isEmpty()) return;
  if (lightPosition) equiangular_.emplace(medium.ray(), range, *lightPosition);
  cutAtQuantiles();
  weighPieces(estimate);
}

void ScatteringDistanceSampler::cutAtQuantiles() {
  const double end = toX(double{range_.t1});
  int n = 0;
  x_[n++] = 0;
  for (int i = 1; i < kQuantiles; ++i) {
    const float u = static_cast<float>(i) / kQuantiles;
    x_[n++] = double{u} * end;
    if (const auto s = transmittance_.sample(u)) x_[n++] = std::clamp(toX(double{s->t}), 0.0, end);
  }
  x_[n++] = end;
  std::sort(x_.begin(), x_.begin() + n);
  const auto last = std::unique(x_.begin(), x_.begin() + n);
  pieces_ = static_cast<int>(last - x_.begin()) - 1;
}

void ScatteringDistanceSampler::weighPieces(const ScatteringEstimate& estimate) {
  std::array<double, kMaxPieces> weight{};
  double sum = 0;
  for (int i = 0; i < pieces_; ++i) {
    const double t = fromX(0.5 * (x_[i] + x_[i + 1]));
    const auto at = std::clamp(static_cast<float>(t), range_.t0, range_.t1);
    const Rgb source = medium_.at(at).sigma_s * medium_.transmittance(at);
    const double value = double{source.average()} * double{estimate.at(at)};
    weight[i] = value * (x_[i + 1] - x_[i]) / xPerLength(t);
    sum += weight[i];
  }
  const double even = sum > 0 && std::isfinite(sum) ? kEvenShare : 1;
  double upTo = 0;
  for (int i = 0; i < pieces_; ++i) {
    upTo_[i] = upTo;
    upTo += even * (x_[i + 1] - x_[i]) / (x_[pieces_] - x_[0]);
    if (even < 1) upTo += (1 - even) * weight[i] / sum;
  }
  for (int i = 0; i < pieces_; ++i) upTo_[i] /= upTo;
  upTo_[pieces_] = 1;
}

std::optional<ScatteringDistanceSampler::Sample> ScatteringDistanceSampler::sample(float u) const {
  float t = 0;
  if (u < kTransmittanceShare) {
    const auto chosen = transmittance_.sample(u / kTransmittanceShare);
    if (!chosen) return std::nullopt;
    t = chosen->t;
  } else {
    const double v = double{u - kTransmittanceShare} / double{1 - kTransmittanceShare};
    const auto next = std::upper_bound(upTo_.begin() + 1, upTo_.begin() + pieces_, v);
    const auto i = static_cast<std::size_t>(next - upTo_.begin()) - 1;
    const double inside = (v - upTo_[i]) / (upTo_[i + 1] - upTo_[i]);
    const double x = x_[i] + std::clamp(inside, 0.0, 1.0) * (x_[i + 1] - x_[i]);
    t = std::clamp(static_cast<float>(fromX(x)), range_.t0, range_.t1);
  }
  Sample s;
  s.t = t;
  s.medium = medium_.at(t);
  const Vec3d depth = medium_.depthAt(t);
  s.Tr = MediumAlongRay::toTransmittance(depth);
  s.pdf = mixture(t, s.medium.sigma_t(), depth);
  if (!(s.pdf > 0)) return std::nullopt;
  return s;
}

float ScatteringDistanceSampler::pdf(float t) const {
  return mixture(t, medium_.at(t).sigma_t(), medium_.depthAt(t));
}

float ScatteringDistanceSampler::tablePdf(float t) const {
  if (!(t >= range_.t0 && t <= range_.t1)) return 0;
  const double x = toX(double{t});
  const auto next = std::upper_bound(x_.begin() + 1, x_.begin() + pieces_, x);
  const auto i = static_cast<std::size_t>(next - x_.begin()) - 1;
  return static_cast<float>((upTo_[i + 1] - upTo_[i]) / (x_[i + 1] - x_[i]) *
                            xPerLength(double{t}));
}

float ScatteringDistanceSampler::mixture(float t, const Rgb& sigma_t, const Vec3d& depth) const {
  return kTransmittanceShare * transmittance_.pdf(sigma_t, depth) +
         (1 - kTransmittanceShare) * tablePdf(t);
}

}  // namespace brume
