// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/volume.h"

namespace brume {

/// Abscissa of the two-point Gauss rule on [-1, 1]: 1/sqrt(3).
inline constexpr double kGauss2 = 0.57735026918962576451;

/// Mean of exp(-x s) for s in [0, 1]: (1 - exp(-x)) / x, 1 at x = 0.
inline double exponentialMean(double x) { return x == 0 ? 1.0 : -std::expm1(-x) / x; }

/// All media along one stretch of a ray, looked up once and kept: optical depth to any t, its
/// inverse, coefficients and emission without touching the volumes again. Overlapping volumes are
/// cut at each other's ends, so attenuation is always that of the total. Invariants: spans are
/// in order, do not overlap, and lie in the range; each holds one or more pieces.
/// An object can be filled again and again without allocating.
class MediumAlongRay {
 public:
  MediumAlongRay() = default;
  MediumAlongRay(const Volume& volume, const Ray& ray, Interval range) {
    assign(volume, ray, range);
  }
  void assign(const Volume& volume, const Ray& ray, Interval range);

  Interval range() const { return range_; }
  /// Int sigma_t over the whole range.
  Rgb opticalDepth() const { return Rgb(toFloat(total_)); }
  /// Int_range.t0^t sigma_t.
  Rgb opticalDepth(double t) const { return toFloat(depthAt(t)); }
  /// The same with all digits, for differences.
  Vec3d depthAt(double t) const;
  Rgb transmittance() const { return exp(-opticalDepth()); }
  Rgb transmittance(double t) const { return toTransmittance(depthAt(t)); }
  static Rgb toTransmittance(const Vec3d& depth) { return exp(-toFloat(depth)); }
  /// The t with opticalDepth(t)[channel] = depth; none when the range holds less. In double: from
  /// one float to the next, dense media may have hundreds of optical depths.
  std::optional<double> invert(int channel, double depth) const;
  /// Coefficients at ray(t).
  MediumCoefficients at(float t) const;
  /// Int exp(-tau(range.t0, t)) Le dt over the range: closed form where one volume is alone (all
  /// its coefficients share one density), elsewhere Gauss-Legendre with subdivision to below 1e-9.
  Rgb emission() const;
  /// Int Le t^2 dt over the range, of the luminance, attenuation ignored: times 1 / totalEmission()
  /// the density per solid angle, at the ray's origin, of directions to Volume::sampleEmission.
  double secondMomentOfEmission() const;
  bool isEmpty() const { return spans_.empty(); }
  /// No sigma_s / sigma_t along the ray is larger, per channel.
  const Rgb& maxAlbedo() const { return maxAlbedo_; }
  /// All media along the ray have the same sigma_t in all channels.
  bool isGrey() const { return isGrey_; }
  /// The medium is one piece of exponential (or constant) density.
  bool isSmooth() const {
    return pieces_.size() == 1 && pieces_.front().form == MediumPiece::Form::Exponential;
  }
  /// Some of the media are tracked (Volume::isTracked): depths are a realisation, drawn once for
  /// this object; at a tentative collision they are those in front of it.
  bool isTracked() const { return isTracked_; }
  /// The range without empty ends, rounded outwards; empty without medium.
  Interval occupied() const;
  const Ray& ray() const { return ray_; }

  /// A stretch on which the same pieces are active.
  struct Span {
    double t0, t1;
    std::uint32_t first, count;  ///< of the active pieces: see piece()
    Vec3d depth;                 ///< optical depth at t0
    Vec3d jump;                  ///< that of tentative collisions at t0, which lie behind it
  };
  std::span<const Span> spans() const { return spans_; }
  /// Active piece i of a span.
  const MediumPiece& piece(const Span& s, std::uint32_t i) const {
    return pieces_[indices_[s.first + i]];
  }

 private:
  static Rgb toFloat(const Vec3d& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
  }
  void sweepOverlaps();
  void findMaxAlbedo();
  void accumulateDepths();
  double density(const MediumPiece& p, double t) const {
    return p.tracked ? p.tracked->densityAt(ray_, t) : p.density(t);
  }
  Vec3d jumpAtStart(const Span& s) const;
  Vec3d depthBetween(const Span& s, double a, double b) const;
  double extinction(const Span& s, int channel, double t) const;
  double depthBetween(const Span& s, int channel, double a, double b) const;
  Vec3d emissionOfOverlap(const Span& s) const;
  Vec3d emissionByGauss(const Span& s, double a, double b, const Vec3d& depthAtA) const;

  Ray ray_;
  Interval range_;
  Rgb maxAlbedo_;
  bool isGrey_ = true, isTracked_ = false;
  std::vector<MediumPiece> pieces_;
  std::vector<std::uint32_t> indices_;
  std::vector<Span> spans_;
  std::vector<double> cuts_;            // scratch of sweepOverlaps
  std::vector<std::uint32_t> byStart_;  // scratch of sweepOverlaps
  std::vector<std::uint32_t> active_;   // scratch of sweepOverlaps
  Vec3d total_{0};
};

/// The s in [0, length] with integral(s) = target, for a monotone integral with its derivative:
/// Newton's method, kept inside a shrinking bracket and replaced by bisection where it stalls.
/// Requires 0 <= target <= integral(length).
template <class Integral, class Derivative>
double invertMonotone(Integral integral, Derivative derivative, double length, double target,
                      double total) {
  if (!(target > 0)) return 0;
  if (target >= total) return length;
  double lo = 0, hi = length, s = length * (target / total);
  double previous = total;
  for (int i = 0; i < 100; ++i) {
    const double error = integral(s) - target;
    if (std::abs(error) <= 4e-16 * target) return s;
    (error < 0 ? lo : hi) = s;
    // A float keeps 24 bits of t: 2^-40 of the bracket is far below it.
    if (hi - lo <= 0x1p-52 * hi) break;
    const double slope = derivative(s);
    double next = s - error / slope;
    if (!(next > lo && next < hi) || std::abs(error) > 0.5 * previous) next = 0.5 * (lo + hi);
    previous = std::abs(error);
    if (next == s) break;
    s = next;
  }
  return s;
}

}  // namespace brume
