// SPDX-License-Identifier: Apache-2.0
// Small lights as seen from the segments of a path: where along a segment to look at which of them.
#pragma once

#include <cmath>

#include "core/medium_along_ray.h"
#include "transport/light_tree.h"

namespace brume {

/// Lights that have a position, and an extent of a tenth of the media's at most, looked at from a
/// distance of a segment that is drawn evenly in the angle under which the light sees it
/// (EquiangularSampler). This is worth its time where free flights, by which the light is found as
/// well, leave much variance behind. A light at the distance n from the segment shines on a stretch
/// of about min(n, L), L the segment's length (n no less than half of the light's extent); with the
/// mean extinction sigma along it a flight ends there x = sigma min(n, L) times, so that flights
/// alone have about the second moment x / n^4, attenuated on the way to the light (tau up to the
/// nearest point) and from it. In units of what a segment at the typical distance has,
///   V = x exp(-2 x - tau) (N / n)^4 / min(1, sigma R)^2,  N = max(min(1 / sigma, R), outside),
/// R the radius of the media, `outside` the light's distance from them: segments look at lights
/// with V > 1/4, at those with an extent, which directions find as well, with V > 2. What is left
/// out has a bounded variance. Test: segment_lights_test.
class SegmentLights {
 public:
  SegmentLights(const Scene& scene, double evenShare);

  struct Sample {
    const Light* light = nullptr;
    float t = 0;
    float pdf = 0;  ///< of light and t together [1/length]
  };
  /// Which lights one segment looks at, found out when first asked for and kept.
  class Chances {
   public:
    /// For the next segment.
    void forget() { isKnown_ = false; }

   private:
    friend class SegmentLights;
    LightTree::Cut<RayReceiver> cut_;
    bool isKnown_ = false;
  };
  /// `channels`: the probability of each channel to draw the flight. False: the segment looks at no
  /// light.
  bool mayHelp(const MediumAlongRay& medium, const Rgb& channels) const;
  /// None when the segment does not look at the light chosen. This and pdf() require mayHelp().
  std::optional<Sample> sample(const MediumAlongRay& medium, const Rgb& channels, Chances& chances,
                               float uChoice, float uDistance) const;
  float pdf(const MediumAlongRay& medium, const Rgb& channels, Chances& chances, const Light& light,
            float t) const;
  /// Whether a segment looks at a light around p.
  bool looksAt(const MediumAlongRay& medium, const Rgb& channels, const Vec3& p,
               float extent = 0) const;

 private:
  void findLeastExtinction();
  const LightTree::Cut<RayReceiver>& cutFor(const MediumAlongRay& medium, Chances& chances) const;

  LightTree lights_;
  Bounds3 media_;
  double mediaRadius_ = 0;
  Vec3d center_{0};  // of a ball that holds all of the lights
  double radius_ = 0;
  double farthestOutside_ = 0;  // of any light from the media
  /// Mean extinction from which no segment looks at any light, all of which are outside.
  double helplessExtinction_ = HUGE_VAL;
};

}  // namespace brume
