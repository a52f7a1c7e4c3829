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

 private:
  double radius2_, alpha_;
  double pass_ = 1;
};

/// Squared radius of one beam or visible point from its own photon count: N photons so far, M new
/// ones in the present pass, r'^2 = r^2 (N + alpha M) / (N + M); the flux gathered so far is scaled
/// alike. Source: Hachisuka, Ogaki, Jensen 2008, Progressive Photon Mapping, section 4.
struct CountedRadius {
  double radius2 = 0;
  double count = 0;
  /// Takes M photons in; returns r'^2 / r^2.
  double shrink(double newPhotons, double alpha) {
    if (!(newPhotons > 0)) return 1;
    const double kept = count + alpha * newPhotons, ratio = kept / (count + newPhotons);
    count = kept;
    radius2 *= ratio;
    return ratio;
  }
};

}  // namespace brume
