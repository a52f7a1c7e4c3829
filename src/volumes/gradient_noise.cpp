// SPDX-License-Identifier: Apache-2.0
#include "volumes/gradient_noise.h"

#include <algorithm>
#include <cmath>

#include "core/rng.h"

namespace brume {
namespace {

/// Lattice cells along an axis up to which a box is looked at cell by cell.
constexpr double kMostCells = 2;
/// Where the lattice of one octave lies in that of the one before: no two share their zeros.
const Vec3d kShift(0.37, 0.71, 0.13);

double fade(double t) { return t * t * t * (t * (6 * t - 15) + 10); }
double mix(double a, double b, double w) { return (1 - w) * a + w * b; }

/// Of (1 - w) a + w b, linear in each of a, b and w.
ValueRange mix(const ValueRange& a, const ValueRange& b, const ValueRange& w) {
  return {std::min(mix(a.lo, b.lo, w.lo), mix(a.lo, b.lo, w.hi)),
          std::max(mix(a.hi, b.hi, w.lo), mix(a.hi, b.hi, w.hi))};
}

/// The lattice repeats itself after so many cells, so that any point has its place in it.
std::int64_t wrapped(double index) {
  constexpr double kPeriod = 0x1p40;
  return static_cast<std::int64_t>(index - kPeriod * std::floor(index / kPeriod));
}

}  // namespace

GradientNoise::Corner GradientNoise::corner(double x, double y, double z) const {
  const std::uint64_t h = hashIntegers(seed_, wrapped(x), wrapped(y), wrapped(z));
  const auto zero = static_cast<std::size_t>((h >> 8) % 3);
  Corner c{{h & 1 ? 1.0 : -1.0, h & 2 ? 1.0 : -1.0, h & 4 ? 1.0 : -1.0}};
  c.g[zero] = 0;
  return c;
}

double GradientNoise::value(const Vec3d& p) const {
  const Vec3d cell = glm::floor(p), f = p - cell;
  double v[8];
  for (int i = 0; i < 8; ++i) {
    const int d[3] = {i & 1, (i >> 1) & 1, i >> 2};
    const Corner c = corner(cell.x + d[0], cell.y + d[1], cell.z + d[2]);
    v[i] = c.g[0] * (f.x - d[0]) + c.g[1] * (f.y - d[1]) + c.g[2] * (f.z - d[2]);
  }
  const double wx = fade(f.x), wy = fade(f.y), wz = fade(f.z);
  return mix(mix(mix(v[0], v[1], wx), mix(v[2], v[3], wx), wy),
             mix(mix(v[4], v[5], wx), mix(v[6], v[7], wx), wy), wz);
}

ValueRange GradientNoise::rangeInCell(const Vec3d& cell, const Bounds3d& part) const {
  ValueRange v[8];
  for (int i = 0; i < 8; ++i) {
    const int d[3] = {i & 1, (i >> 1) & 1, i >> 2};
    const Corner c = corner(cell.x + d[0], cell.y + d[1], cell.z + d[2]);
    for (int a = 0; a < 3; ++a) {
      const double lo = c.g[a] * (part.lo[a] - d[a]), hi = c.g[a] * (part.hi[a] - d[a]);
      v[i].lo += std::min(lo, hi);
      v[i].hi += std::max(lo, hi);
    }
  }
  ValueRange w[3];
  for (int a = 0; a < 3; ++a) w[a] = {fade(part.lo[a]), fade(part.hi[a])};
  return mix(mix(mix(v[0], v[1], w[0]), mix(v[2], v[3], w[0]), w[1]),
             mix(mix(v[4], v[5], w[0]), mix(v[6], v[7], w[0]), w[1]), w[2]);
}

ValueRange GradientNoise::range(const Bounds3d& box) const {
  const Vec3d first = glm::floor(box.lo), last = glm::floor(box.hi);
  const Vec3d span = last - first;
  if (!(std::max({span.x, span.y, span.z}) < kMostCells)) return {-kLargestNoise, kLargestNoise};
  ValueRange all{kLargestNoise, -kLargestNoise};
  for (double z = 0; z <= span.z; ++z)
    for (double y = 0; y <= span.y; ++y)
      for (double x = 0; x <= span.x; ++x) {
        const Vec3d cell = first + Vec3d(x, y, z);
        Bounds3d part;
        for (int a = 0; a < 3; ++a) {
          part.lo[a] = std::clamp(box.lo[a] - cell[a], 0.0, 1.0);
          part.hi[a] = std::clamp(box.hi[a] - cell[a], 0.0, 1.0);
        }
        const ValueRange r = rangeInCell(cell, part);
        all = {std::min(all.lo, r.lo), std::max(all.hi, r.hi)};
      }
  return {std::max(all.lo, -kLargestNoise), std::min(all.hi, kLargestNoise)};
}

FractalNoise::FractalNoise(std::uint64_t seed, int octaves, double gain)
    : noise_(seed), octaves_(octaves), gain_(gain) {
  double sum = 0, weight = 1;
  for (int k = 0; k < octaves; ++k, weight *= gain) sum += weight;
  scale_ = 1 / sum;
}

double FractalNoise::value(const Vec3d& p) const {
  double sum = 0, weight = scale_, frequency = 1;
  for (int k = 0; k < octaves_; ++k, weight *= gain_, frequency *= 2)
    sum += weight * noise_.value(p * frequency + kShift * double(k));
  return sum;
}

ValueRange FractalNoise::range(const Bounds3d& box) const {
  ValueRange sum;
  double weight = scale_, frequency = 1;
  for (int k = 0; k < octaves_; ++k, weight *= gain_, frequency *= 2) {
    const Vec3d shift = kShift * double(k);
    const ValueRange r = noise_.range({box.lo * frequency + shift, box.hi * frequency + shift});
    sum.lo += weight * r.lo;
    sum.hi += weight * r.hi;
  }
  return sum;
}

}  // namespace brume
