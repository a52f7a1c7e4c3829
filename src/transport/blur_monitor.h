// SPDX-License-Identifier: Apache-2.0
// How much of a progressive render's error is blur, from its own passes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/math.h"
#include "core/rgb.h"

namespace brume {

/// The photons' part of one pass in one pixel, as its sample saw it.
struct ProbeLight {
  std::array<Rgb, 2> photons;  ///< of beams, of surfaces: BlurMonitor::Kind
  Rgb all;                     ///< the whole sample
};

/// Pass j with squared radius s_j sees L + c s_j, whose noise another pass does not share, so that
/// the slope of a pixel's passes over s_j tells the blur of their mean, c mean(s), and of the
/// square of that the mean over pixels is known well where one pixel's is not. The passes are dealt
/// to kGroups groups g; with a group's blur b_g by least squares and with its mean m_g,
///   squared blur  B = sum_{g < h} w_g w_h <b_g b_h> / sum_{g < h} w_g w_h
///                     without bias, as the groups' noise is independent; w_g is the spread of the
///                     group's s, which its blur's variance is inverse to
///   variance      V = < sum_g (m_g - mean m)^2 / (kGroups (kGroups - 1)) >
/// where <> is the mean over probed pixels, each relative to its brightness as in
/// Film::estimatedRelativeError. That each pair of groups tells B gives its standard error,
/// whatever the pixels of a pass share. Memory: a fixed number of probes. Test: blur_monitor_test.
class BlurMonitor {
 public:
  enum Kind : std::uint8_t { Beams, Surfaces };
  /// Parts of the squared relative error of the mean of all passes.
  struct Estimate {
    double blur2 = 0;  ///< noise may make it negative
    double blur2Error = 0;
    double variance = 0;
    /// Noise does so in 3 % of all cases, and in 0.2 % by five standard errors.
    bool standsOut(double standardErrors = 3) const { return blur2 > standardErrors * blur2Error; }
    /// What radii should be multiplied with so that blur is kNoiseOverBlur times below noise:
    ///   V x^-2 = kNoiseOverBlur B x^3
    /// with the laws of firstRadii; 1 unless blur is beyond doubt and x worth the change, and not
    /// below a half at once.
    double radiusFactor() const;
  };
  static constexpr int kProbesPerAxis = 32;
  static constexpr std::size_t kGroups = 8;

  explicit BlurMonitor(const Bounds2i& pixels);
  std::size_t probeCount() const { return probes_.size(); }
  /// The probe that looks through this pixel.
  std::optional<std::uint32_t> probeOf(Vec2i pixel) const;

  /// Light of every probe; squared radii by kind [length^2], 0 where there are no such photons.
  void addPass(std::span<const ProbeLight> light, std::array<double, 2> radius2);

  /// None before each group has enough passes, or where the radius did not change.
  std::optional<Estimate> estimate(Kind kind) const;

 private:
  struct Sums {
    std::array<std::array<double, 3>, 2> light{}, byRadius2{};  // sum L, sum s L
  };
  struct Group {
    std::int64_t passes = 0;
    std::array<double, 2> radius2{}, radius4{};  // sum s, sum s^2
  };
  struct Probe {
    std::array<Sums, kGroups> groups;
    std::array<double, 3> all{};
  };
  std::vector<double> weights() const;

  Bounds2i pixels_;
  std::vector<int> columns_, rows_;  // of a pixel, or -1
  int perRow_ = 0;
  std::vector<Probe> probes_;
  std::array<Group, kGroups> groups_{};
  std::int64_t passes_ = 0;
};

}  // namespace brume
