// SPDX-License-Identifier: Apache-2.0
#include "support/reference_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace brume::test {

namespace {

constexpr double kTwoPi = 6.28318530717958647692;

Point operator+(const Point& a, const Point& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point operator*(const Point& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Point unit(const Point& a) { return a * (1 / std::sqrt(dot(a, a))); }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

class Walk {
 public:
  Walk(const ReferenceScene& scene, std::size_t channel, std::uint64_t seed)
      : s_(scene), c_(channel), random_(seed) {
    for (const ReferenceMedium& m : s_.media)
      majorant_ += m.maxDensity * (m.sigma_a[c_] + m.sigma_s[c_]);
    hullLo_ = s_.media.front().lo;
    hullHi_ = s_.media.front().hi;
    for (const ReferenceMedium& m : s_.media)
      for (std::size_t a = 0; a < 3; ++a) {
        hullLo_[a] = std::min(hullLo_[a], m.lo[a]);
        hullHi_[a] = std::max(hullHi_[a], m.hi[a]);
      }
  }

  /// One path from the camera, all its scatterings lit by the light.
  double path() {
    Point p = s_.camera, d = unit(s_.target - s_.camera);
    double weight = 1, L = 0;
    while (nextCollision(p, d)) {
      const double sigma_s = scattering(p), sigma_t = sigma_s + absorption(p);
      weight *= sigma_s / sigma_t;
      L += weight * lit(p, d);
      // Roulette at a tenth, survival one half.
      if (weight < 0.1) {
        if (uniform() < 0.5) break;
        weight *= 2;
      }
      d = turned(p, d);
    }
    return L;
  }

 private:
  double uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }

  double densityOf(const ReferenceMedium& m, const Point& p) const {
    for (std::size_t a = 0; a < 3; ++a)
      if (p[a] < m.lo[a] || p[a] > m.hi[a]) return 0;
    return m.density(p);
  }
  double scattering(const Point& p) const {
    double sum = 0;
    for (const ReferenceMedium& m : s_.media) sum += densityOf(m, p) * m.sigma_s[c_];
    return sum;
  }
  double absorption(const Point& p) const {
    double sum = 0;
    for (const ReferenceMedium& m : s_.media) sum += densityOf(m, p) * m.sigma_a[c_];
    return sum;
  }
  /// The part of the ray in the box around all media.
  bool hull(const Point& o, const Point& d, double& t0, double& t1) const {
    for (std::size_t a = 0; a < 3; ++a) {
      if (d[a] == 0) {
        if (o[a] < hullLo_[a] || o[a] > hullHi_[a]) return false;
        continue;
      }
      const double x = (hullLo_[a] - o[a]) / d[a], y = (hullHi_[a] - o[a]) / d[a];
      t0 = std::max(t0, std::min(x, y));
      t1 = std::min(t1, std::max(x, y));
    }
    return t0 < t1;
  }
  /// Moves p to the next collision; false when it leaves.
  bool nextCollision(Point& p, const Point& d) {
    double t = 0, end = std::numeric_limits<double>::infinity();
    if (!hull(p, d, t, end)) return false;
    for (;;) {
      t -= std::log1p(-uniform()) / majorant_;
      if (t >= end) return false;
      const Point at = p + d * t;
      if (uniform() * majorant_ < scattering(at) + absorption(at)) {
        p = at;
        return true;
      }
    }
  }
  /// Light scattered at p into the direction -d, per albedo.
  double lit(const Point& p, const Point& d) {
    const Point toLight = s_.light - p;
    const double distance = std::sqrt(dot(toLight, toLight));
    const Point w = toLight * (1 / distance);
    double phase = 0;
    for (const ReferenceMedium& m : s_.media)
      phase += densityOf(m, p) * m.sigma_s[c_] * henyeyGreenstein(m.g, dot(d, w));
    return phase / scattering(p) * s_.I[c_] / (distance * distance) * transmittance(p, w, distance);
  }
  static double henyeyGreenstein(double g, double cosine) {
    return (1 - g * g) / (2 * kTwoPi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
  }
  /// Ratio tracking.
  double transmittance(const Point& p, const Point& w, double distance) {
    double t = 0, end = distance, Tr = 1;
    if (!hull(p, w, t, end)) return 1;
    for (;;) {
      t -= std::log1p(-uniform()) / majorant_;
      if (t >= end) return Tr;
      const Point at = p + w * t;
      Tr *= 1 - (scattering(at) + absorption(at)) / majorant_;
    }
  }
  Point turned(const Point& p, const Point& d) {
    double rest = uniform() * scattering(p), g = 0;
    for (const ReferenceMedium& m : s_.media) {
      const double share = densityOf(m, p) * m.sigma_s[c_];
      if (share == 0) continue;
      g = m.g;
      if (rest < share) break;
      rest -= share;
    }
    const double u = uniform(), phi = kTwoPi * uniform();
    const double q = (1 - g * g) / (1 - g + 2 * g * u);
    const double cosine =
        std::abs(g) < 1e-3 ? 2 * u - 1 : std::clamp((1 + g * g - q * q) / (2 * g), -1.0, 1.0);
    const double sine = std::sqrt(1 - cosine * cosine);
    const Point x = unit(cross(d, std::abs(d[0]) < 0.5 ? Point{1, 0, 0} : Point{0, 1, 0}));
    const Point y = cross(d, x);
    return unit(d * cosine + x * (sine * std::cos(phi)) + y * (sine * std::sin(phi)));
  }

  const ReferenceScene& s_;
  std::size_t c_;
  std::mt19937_64 random_;
  double majorant_ = 0;
  Point hullLo_, hullHi_;
};

}  // namespace

Estimate referenceRadiance(const ReferenceScene& scene, std::size_t channel, std::int64_t paths,
                           std::uint64_t seed) {
  Walk walk(scene, channel, seed);
  double sum = 0, squares = 0;
  for (std::int64_t i = 0; i < paths; ++i) {
    const double L = walk.path();
    sum += L;
    squares += L * L;
  }
  const double n = static_cast<double>(paths), mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1))};
}

}  // namespace brume::test
