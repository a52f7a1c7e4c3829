// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_sources.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace brume {
namespace {

/// Below this share of a light's power towards the media its paths are split.
constexpr float kSmallShare = 0.4f;
/// Balls of one light; where the scene is larger than so many doublings of the media, they grow
/// faster.
constexpr int kMaxBalls = 16;

/// Whether a light path would enter the ball, as oneMinusCosSeen sees it.
bool meets(const Ball& ball, const LightEmission& emission) {
  const Vec3d toCenter = Vec3d(ball.center) - Vec3d(emission.o), d(emission.d);
  const double along = dot(toCenter, d), distance2 = dot(toCenter, toCenter),
               radius2 = sqr(double{ball.radius});
  // Far away, the rounding of d's length counts.
  return distance2 <= radius2 || (along > 0 && distance2 - along * along / dot(d, d) <= radius2);
}

}  // namespace

PhotonSources::PhotonSources(const Scene& scene, const Options& options) : volume_(scene.volume()) {
  makeBalls(scene, options.media);
  std::vector<float> weights;
  for (const auto& light : scene.lights()) addLight(*light, options.forSurfaces, weights);
  if (volume_ && volume_->isEmissive() && options.withMedia) {
    sources_.push_back({});
    weights.push_back(4 * kPi * lightWeight(volume_->totalEmission()));
  }
  if (!weights.empty()) choice_ = Distribution1D(weights);
}

void PhotonSources::makeBalls(const Scene& scene, const Ball& media) {
  const Ball all = ballAround(scene.bounds());
  if (media.radius > 0) {
    const float whole = distance(media.center, all.center) + all.radius;
    const float growth = std::max(2.f, std::pow(whole / media.radius, 1.f / kMaxBalls));
    for (float radius = media.radius; radius < whole; radius *= growth)
      balls_.push_back({media.center, radius});
  }
  balls_.push_back(all);
}

void PhotonSources::addLight(const Light& light, bool forSurfaces, std::vector<float>& weights) {
  const std::size_t last = balls_.size() - 1;
  const float weight = lightWeight(light.powerToward(balls_[last]));
  if (!(weight > 0) || !std::isfinite(weight)) return;
  const float toMedia = last > 0 ? lightWeight(light.powerToward(balls_[0])) : 0.f;
  if (!(toMedia > 0 && toMedia < kSmallShare * weight)) {
    sources_.push_back({&light, last, last, 1});
    weights.push_back(weight);
    return;
  }
  // The shells share evenly, or half evenly and half by power where surfaces want photons.
  std::vector<float> power{toMedia};
  float outside = 0;
  for (std::size_t i = 1; i <= last; ++i) {
    power.push_back(lightWeight(light.powerToward(balls_[i])));
    outside += std::max(0.f, power[i] - power[i - 1]);
  }
  for (std::size_t i = 0; i <= last; ++i) {
    float share = 1;
    if (i > 0) {
      const float even = 1.f / static_cast<float>(last);
      share = forSurfaces && outside > 0
                  ? 0.5f * (even + std::max(0.f, power[i] - power[i - 1]) / outside)
                  : even;
    }
    sources_.push_back({&light, 0, i, toMedia * share / power[i]});
    weights.push_back(0.5f * weight * share);
  }
}

std::optional<PhotonStart> PhotonSources::sample(PathRandom& random) const {
  const float uSource = random.get1D();
  const std::size_t chosen = sources_.size() > 1 ? choice_.sample(uSource).index : 0;
  EmissionUniforms u;
  u.point = random.get2D();
  u.direction = random.get2D();
  const Source& source = sources_[chosen];
  std::optional<PhotonStart> start;
  if (!source.light) {
    start = sampleMedia(random, sampleUniformSphere(u.direction));
    if (!start) return start;
  } else {
    const auto e = source.light->sampleEmission(balls_[source.ball], u);
    if (!e) return start;
    for (std::size_t i = source.first; i < source.ball; ++i)
      if (meets(balls_[i], *e)) return start;
    if (source.ball + 1 != balls_.size() && !meets(balls_[source.ball], *e)) return start;
    start.emplace(PhotonStart{e->o, e->d, e->power});
  }
  start->power /= choice_.probability(chosen);
  start->usualPower = source.usualShare * largestChannel(start->power);
  if (!(start->usualPower > 0) || !start->power.isFinite()) start.reset();
  return start;
}

void PhotonSources::setShares(std::span<const float> shares) {
  const Distribution1D before = std::exchange(choice_, Distribution1D(shares));
  std::size_t towardMedia = 0;  // of the same light
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    Source& source = sources_[i];
    if (source.ball == source.first) towardMedia = i;
    // The power of paths goes as 1 / share.
    const auto change = [&](std::size_t s) {
      return before.probability(s) / choice_.probability(s);
    };
    source.usualShare = std::min(1.f, source.usualShare * change(towardMedia) / change(i));
  }
}

/// A point by the luminance of Le: alpha = 4 pi Le(p) / pdf(p).
std::optional<PhotonStart> PhotonSources::sampleMedia(PathRandom& random,
                                                      const Vec3& direction) const {
  Rng apart = random.apart();
  const Vec3 p = volume_->sampleEmission(apart);
  const Rgb Le = volume_->at(p).Le;
  if (!(lightWeight(Le) > 0)) return std::nullopt;
  return PhotonStart{p, direction,
                     Le * (4 * kPi * lightWeight(volume_->totalEmission()) / lightWeight(Le)), 0,
                     true};
}

}  // namespace brume
