// SPDX-License-Identifier: Apache-2.0
// Where light paths begin.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/light.h"
#include "core/sampling.h"
#include "core/scene.h"
#include "transport/path_random.h"

namespace brume {

/// The largest of the channels' absolute values: what roulette goes by.
inline float largestChannel(const Rgb& power) {
  return std::max(std::abs(power.r), std::max(std::abs(power.g), std::abs(power.b)));
}

/// The first ray of a light path.
struct PhotonStart {
  Vec3 o{0}, d{0};          ///< d: unit, the way the light travels
  Rgb power;                ///< alpha, over the density of all choices [W]
  float usualPower = 0;     ///< largest channel of the power that photons should have [W]
  bool isInMedium = false;  ///< emitted by the media
};

/// All that emits photons: lights by the power that they send to the scene, and emissive media, as
/// one more light of power 4 pi Int Le dV, by the luminance of Le.
///
/// Where the media are much smaller than the scene, half of a light's paths are aimed at the ball
/// around them. The other half is shared between shells around that ball, each twice as large as
/// the one inside it, the last the scene: what falls on the ground beside the media reaches them
/// far more often than what falls on the horizon. A ray belongs to the innermost ball that it
/// meets: there is one way to draw it. Rays of outer shells carry more power than those towards
/// the media; usualPower is that of the latter.
/// Those shares are a guess; a method that knows what its photons do for the image sets better
/// ones. Thread-safe but for setShares. Test: photon_tracer_test.
class PhotonSources {
 public:
  struct Options {
    Ball media;               ///< around the media whose photons are wanted; radius 0: none are
    bool forSurfaces = true;  ///< photons on surfaces are wanted, too
    bool withMedia = true;    ///< the media emit
  };
  PhotonSources(const Scene& scene, const Options& options);

  bool isEmpty() const { return sources_.empty(); }
  /// None: this path carries nothing.
  std::optional<PhotonStart> sample(PathRandom& random) const;

  /// Sources in this sense are a light's rays to one ball or shell each, and the media.
  std::size_t count() const { return sources_.size(); }
  /// Which one `sample` would take.
  std::size_t sourceOf(PathRandom random) const { return choice_.sample(random.get1D()).index; }
  /// Of all paths.
  float share(std::size_t source) const { return choice_.probability(source); }
  /// Above 0 for every source that has a share.
  void setShares(std::span<const float> shares);

 private:
  /// A light's rays that meet balls_[ball] and none of those before, from `first` on.
  struct Source {
    const Light* light = nullptr;  // null: the media
    std::size_t first = 0, ball = 0;
    float usualShare = 1;  // usualPower over the power of its paths
  };
  void makeBalls(const Scene& scene, const Ball& media);
  void addLight(const Light& light, bool forSurfaces, std::vector<float>& weights);
  std::optional<PhotonStart> sampleMedia(PathRandom& random, const Vec3& direction) const;

  const Volume* volume_;
  std::vector<Ball> balls_;  // nested; the last is the scene's
  std::vector<Source> sources_;
  Distribution1D choice_;  // over sources_
};

}  // namespace brume
