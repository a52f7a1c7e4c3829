// SPDX-License-Identifier: Apache-2.0
#include "core/sampling.h"

#include <algorithm>

#include "core/error.h"
#include "core/turns.h"

namespace brume {

Vec2 cosSinOfTurns(float u) {
  const CosSin turn = cosSinOfTurn(u);
  return {turn.cosine, turn.sine};
}

Vec2 sampleConcentricDisk(Vec2 u) {
  const float x = 2.f * u.x - 1.f, y = 2.f * u.y - 1.f;
  if (x == 0.f && y == 0.f) return Vec2(0);
  // The angle from the nearer axis: the functions of a small angle do for the whole circle.
  const bool horizontal = std::abs(x) > std::abs(y);
  const float r = horizontal ? x : y;
  const CosSin small = cosSinOfSmall((kPi / 4) * (horizontal ? y / x : x / y));
  return horizontal ? Vec2(r * small.cosine, r * small.sine)
                    : Vec2(r * small.sine, r * small.cosine);
}

Vec3 sampleCosineHemisphere(Vec2 u) {
  const Vec2 d = sampleConcentricDisk(u);
  return {d.x, d.y, safeSqrt(1.f - d.x * d.x - d.y * d.y)};
}

Vec3 sampleUniformHemisphere(Vec2 u) {
  const float z = u.x, r = safeSqrt(1.f - z * z);
  const Vec2 cs = cosSinOfTurns(u.y);
  return {r * cs.x, r * cs.y, z};
}

Vec3 sampleUniformSphere(Vec2 u) {
  const float z = 1.f - 2.f * u.x, r = safeSqrt(1.f - z * z);
  const Vec2 cs = cosSinOfTurns(u.y);
  return {r * cs.x, r * cs.y, z};
}

Vec3 sampleUniformCone(Vec2 u, float oneMinusCosThetaMax) {
  const float oneMinusCos = u.x * oneMinusCosThetaMax;
  const float sinTheta = safeSqrt(oneMinusCos * (2.f - oneMinusCos));
  const Vec2 cs = cosSinOfTurns(u.y);
  return {sinTheta * cs.x, sinTheta * cs.y, 1.f - oneMinusCos};
}

Vec2 sampleUniformTriangle(Vec2 u) {
  const float s = std::sqrt(u.x);
  return {1.f - s, u.y * s};
}

namespace {
/// So that a product of a float's digits and a number of cells is exact in double.
constexpr std::size_t kMostCells = std::size_t{1} << 29;
}  // namespace

Distribution1D::Distribution1D(std::span<const float> values) : cdf_(values.size() + 1, 0.0) {
  BRUME_CHECK(!values.empty() && values.size() < kMostCells);
  const std::size_t size = values.size();
  const auto n = static_cast<double>(size);
  for (std::size_t i = 0; i < size; ++i) cdf_[i + 1] = cdf_[i] + values[i] / n;
  integral_ = cdf_.back();
  for (std::size_t i = 1; i <= size; ++i)
    cdf_[i] = integral_ > 0 ? cdf_[i] / integral_ : static_cast<double>(i) / n;
  guide_.reserve(size + 1);
  std::size_t cell = 0;
  for (std::size_t part = 0; part <= size; ++part) {
    while (cell + 1 < size && cdf_[cell + 1] <= static_cast<double>(part) / n) ++cell;
    guide_.push_back(static_cast<std::uint32_t>(cell));
  }
}

std::size_t Distribution1D::cellAt(double u) const {
  // u is at or after the beginning of its part: the product is exact.
  const auto part = std::min(size() - 1, static_cast<std::size_t>(u * static_cast<double>(size())));
  const auto first = cdf_.begin() + guide_[part], last = cdf_.begin() + guide_[part + 1] + 1;
  return static_cast<std::size_t>(std::upper_bound(first + 1, last, u) - cdf_.begin() - 1);
}

Distribution1D::Sample Distribution1D::sample(float u) const {
  const std::size_t i = cellAt(std::clamp(double{u}, 0.0, 1.0));
  const double width = cdf_[i + 1] - cdf_[i];
  const double inCell = width > 0 ? (u - cdf_[i]) / width : 0.5;
  const auto n = static_cast<double>(size());
  float x = static_cast<float>((static_cast<double>(i) + std::clamp(inCell, 0.0, 1.0)) / n);
  // Rounding must not carry x into the next cell, which may be empty.
  while (static_cast<std::size_t>(x * static_cast<float>(n)) > i) x = std::nextafter(x, 0.f);
  return {x, probability(i) * static_cast<float>(n), i};
}

float Distribution1D::pdf(float x) const {
  const float n = static_cast<float>(size());
  const std::size_t i = std::min(size() - 1, static_cast<std::size_t>(std::max(0.f, x * n)));
  return probability(i) * n;
}

float Distribution1D::probability(std::size_t i) const {
  return static_cast<float>(cdf_[i + 1] - cdf_[i]);
}

Distribution2D::Distribution2D(std::span<const float> values, std::size_t width,
                               std::size_t height) {
  BRUME_CHECK(width > 0 && height > 0 && values.size() == width * height);
  rows_.reserve(height);
  std::vector<float> sums(height);
  for (std::size_t y = 0; y < height; ++y) {
    rows_.emplace_back(values.subspan(y * width, width));
    sums[y] = static_cast<float>(rows_.back().integral());
  }
  marginal_ = Distribution1D(sums);
}

Distribution2D::Sample Distribution2D::sample(Vec2 u) const {
  const Distribution1D::Sample y = marginal_.sample(u.y);
  const Distribution1D::Sample x = rows_[y.index].sample(u.x);
  return {Vec2(x.x, y.x), x.pdf * y.pdf};
}

float Distribution2D::pdf(Vec2 p) const {
  const std::size_t y =
      std::min(rows_.size() - 1,
               static_cast<std::size_t>(std::max(0.f, p.y * static_cast<float>(rows_.size()))));
  return rows_[y].pdf(p.x) * marginal_.pdf(p.y);
}

}  // namespace brume
