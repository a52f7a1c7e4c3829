// SPDX-License-Identifier: Apache-2.0
#include "transport/distance_sampling.h"

namespace brume {

namespace {

/// Shares of the two kinds of table that do not trust the estimate.
constexpr double kEvenShare = 0.02;
constexpr double kCollisionShare = 0.1;
/// Optical depth up to which a density linear between the cuts follows the attenuation.
constexpr double kThin = 16;
/// Optical depth from which on the tail of the attenuation is cut once more.
constexpr double kTailed = 2;

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

double TransmittanceSampler::strengthSeenFrom(const Rgb& Tr) const {
  double sum = 0;
  for (int c = 0; c < 3; ++c)
    sum += double{medium_.maxAlbedo()[c]} * double{Tr[c]} * -std::expm1(-inside_[c]);
  return sum;
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
  isLinear_ = estimate.isReliable() && transmittance_.depth() <= kThin;
  cutAtQuantiles();
  if (isLinear_)
    tabulateDensity(estimate);
  else
    tabulateCollisions(estimate);
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
  // The tail of the attenuation, where one piece would be too long for a linear density.
  if (transmittance_.depth() > kTailed)
    for (const float u : {31.f / 32, 511.f / 512})
      if (const auto s = transmittance_.sample(u))
        x_[n++] = std::clamp(toX(double{s->t}), 0.0, end);
  x_[n++] = end;
  std::sort(x_.begin(), x_.begin() + n);
  // Cuts that a float cannot tell apart are one.
  const auto last = std::unique(x_.begin(), x_.begin() + n, [this](double a, double b) {
    return !(static_cast<float>(fromX(b)) > static_cast<float>(fromX(a)));
  });
  pieces_ = std::max(1, static_cast<int>(last - x_.begin()) - 1);
  x_[pieces_] = end;
}

void ScatteringDistanceSampler::tabulateDensity(const ScatteringEstimate& estimate) {
  std::array<double, kMaxPieces + 1> value{};
  double sum = 0;
  for (int i = 0; i <= pieces_; ++i) {
    const auto t = std::clamp(static_cast<float>(fromX(x_[i])), range_.t0, range_.t1);
    const Rgb source = medium_.at(t).sigma_s * medium_.transmittance(t);
    value[i] = source.isBlack()
                   ? 0
                   : double{source.average()} * double{estimate.at(t)} / xPerLength(double{t});
    if (i > 0) sum += 0.5 * (value[i - 1] + value[i]) * (x_[i] - x_[i - 1]);
  }
  const double even = sum > 0 && std::isfinite(sum) ? kEvenShare : 1;
  for (int i = 0; i <= pieces_; ++i) {
    density_[i] = even / (x_[pieces_] - x_[0]);
    if (even < 1) density_[i] += (1 - even) * value[i] / sum;
    if (i > 0)
      upTo_[i] = upTo_[i - 1] + 0.5 * (density_[i - 1] + density_[i]) * (x_[i] - x_[i - 1]);
  }
}

void ScatteringDistanceSampler::tabulateCollisions(const ScatteringEstimate& estimate) {
  for (int i = 0; i <= pieces_; ++i)
    t_[i] = std::clamp(static_cast<float>(fromX(x_[i])), range_.t0, range_.t1);
  t_[0] = range_.t0;
  t_[pieces_] = range_.t1;
  std::array<double, kMaxPieces> collisions{}, value{};
  double sumCollisions = 0, sum = 0;
  for (int i = 0; i < pieces_; ++i) {
    const Interval part{t_[i], t_[i + 1]};
    const Rgb Tr = medium_.transmittance(part.t0);
    const TransmittanceSampler inside(medium_, part);
    collisions[i] = inside.strengthSeenFrom(Tr);
    const auto median = inside.isEmpty() ? std::nullopt : inside.sample(0.5f);
    if (!median || !(collisions[i] > 0)) continue;
    value[i] = collisions[i] * double{estimate.at(median->t)};
    sumCollisions += collisions[i];
    sum += value[i];
  }
  const double blind = sum > 0 && std::isfinite(sum) ? kCollisionShare : 1;
  for (int i = 0; i < pieces_; ++i) {
    upTo_[i + 1] = upTo_[i] + blind * collisions[i] / sumCollisions;
    if (blind < 1) upTo_[i + 1] += (1 - blind) * value[i] / sum;
  }
}

std::size_t ScatteringDistanceSampler::findPiece(const std::array<double, kMaxPieces + 1>& borders,
                                                 double value) const {
  const auto next = std::upper_bound(borders.begin() + 1, borders.begin() + pieces_, value);
  return static_cast<std::size_t>(next - borders.begin()) - 1;
}

std::optional<float> ScatteringDistanceSampler::distanceIn(std::size_t i, double w) const {
  if (!isLinear_) {
    const TransmittanceSampler inside(medium_, {t_[i], t_[i + 1]});
    if (inside.isEmpty()) return std::nullopt;
    const auto s = inside.sample(static_cast<float>(w));
    return s ? std::optional<float>(s->t) : std::nullopt;
  }
  // A linear density from d0 to d1: its distribution inverted without a difference of roots.
  const double d0 = density_[i], d1 = density_[i + 1];
  const double s = w * (d0 + d1) / (d0 + std::sqrt(d0 * d0 + w * (d1 * d1 - d0 * d0)));
  const double x = x_[i] + s * (x_[i + 1] - x_[i]);
  return std::clamp(static_cast<float>(fromX(x)), range_.t0, range_.t1);
}

std::optional<ScatteringDistanceSampler::Sample> ScatteringDistanceSampler::sample(float u) const {
  const double v = double{u} * upTo_[pieces_];
  const std::size_t i = findPiece(upTo_, v);
  const double mass = upTo_[i + 1] - upTo_[i];
  if (!(mass > 0)) return std::nullopt;
  const auto t = distanceIn(i, std::clamp((v - upTo_[i]) / mass, 0.0, 1.0));
  if (!t) return std::nullopt;
  Sample s;
  s.t = *t;
  s.medium = medium_.at(*t);
  const Vec3d depth = medium_.depthAt(*t);
  s.Tr = MediumAlongRay::toTransmittance(depth);
  s.pdf = pdf(*t, s.medium.sigma_t(), depth);
  if (!(s.pdf > 0)) return std::nullopt;
  return s;
}

float ScatteringDistanceSampler::pdf(float t) const {
  return pdf(t, medium_.at(t).sigma_t(), medium_.depthAt(t));
}

float ScatteringDistanceSampler::pdf(float t, const Rgb& sigma_t, const Vec3d& depth) const {
  if (!(t >= range_.t0 && t <= range_.t1)) return 0;
  if (!isLinear_) {
    const auto next = std::upper_bound(t_.begin() + 1, t_.begin() + pieces_, t);
    const auto i = static_cast<std::size_t>(next - t_.begin()) - 1;
    const TransmittanceSampler inside(medium_, {t_[i], t_[i + 1]});
    return static_cast<float>((upTo_[i + 1] - upTo_[i]) / upTo_[pieces_] *
                              double{inside.pdf(sigma_t, depth)});
  }
  const double x = toX(double{t});
  const std::size_t i = findPiece(x_, x);
  const double inside = std::clamp((x - x_[i]) / (x_[i + 1] - x_[i]), 0.0, 1.0);
  const double density = density_[i] + inside * (density_[i + 1] - density_[i]);
  return static_cast<float>(density / upTo_[pieces_] * xPerLength(double{t}));
}

}  // namespace brume
