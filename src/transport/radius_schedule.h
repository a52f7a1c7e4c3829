// SPDX-License-Identifier: Apache-2.0
// How the radius of progressive photon mapping shrinks.
#pragma once

#include "core/math.h"

namespace brume {

/// Squared radii of passes 1, 2, ...: r_{j+1}^2 = r_j^2 (j + alpha) / (j + 1), 0 < alpha < 1.
/// The mean over passes of independent estimates with a 2-D kernel of these radii converges: its
/// variance falls like j^-alpha, its bias like j^(alpha-1); alpha = 2/3 balances their squares.
/// Source: Knaus, Zwicker 2011, Progressive Photon Mapping: A Probabilistic Approach.
class RadiusSchedule {
 public:
  RadiusSchedule(double firstRadius, double alpha)
      : radius2_(firstRadius * firstRadius), alpha_(alpha) {}
  /// Of the present pass, [scene length^2].
  double radius2() const { return radius2_; }
  void advance() {
    radius2_ *= (pass_ + alpha_) / (pass_ + 1);
    pass_ += 1;
  }
  /// Multiplies the radii of the passes to come.
  void scale(double factor) { radius2_ *= factor * factor; }

 private:
  double radius2_, alpha_;
  double pass_ = 1;
};

/// Squared radius of one beam from its own photons: N so far, M new ones in the present pass,
///   r'^2 = r^2 (N + alpha M) / (N + M)
/// The flux gathered so far is scaled alike, so flux over area stays what it was: with a normalised
/// kernel the result is the mean of the passes' estimates here too. Source: Hachisuka, Ogaki,
/// Jensen 2008, Progressive Photon Mapping, section 4.
class CountedRadius {
 public:
  explicit CountedRadius(double firstRadius) : radius2_(firstRadius * firstRadius) {}
  double radius2() const { return radius2_; }
  void shrink(double newPhotons, double alpha) {
    if (!(newPhotons > 0)) return;
    const double kept = count_ + alpha * newPhotons;
    radius2_ *= kept / (count_ + newPhotons);
    count_ = kept;
  }

 private:
  double radius2_, count_ = 0;
};

}  // namespace brume
