// SPDX-License-Identifier: Apache-2.0
#include "transport/emission_sampling.h"

#include <bit>

#include "core/rng.h"

namespace brume {
namespace {

/// Upper estimate of the radiant intensity of one volume: all that it emits, but no more than its
/// projected area times the radiance of a thick medium, Le / sigma_t.
LightBounds boundsOf(const Volume& volume) {
  LightBounds bounds;
  bounds.box = volume.bounds();
  bounds.intensity = double{volume.totalEmission().luminance()};
  Rng rng(1);
  const MediumCoefficients at = volume.at(volume.sampleEmission(rng));
  const double sigma_t = double{at.sigma_t().luminance()};
  if (sigma_t > 0) {
    const Vec3d d(bounds.box.diagonal());
    // A convex body shows a quarter of its surface on the mean.
    const double shown = 0.5 * (d.x * d.y + d.y * d.z + d.z * d.x);
    bounds.intensity = std::min(bounds.intensity, shown * double{at.Le.luminance()} / sigma_t);
  }
  return bounds;
}

}  // namespace

EmissionSampler::EmissionSampler(const Scene& scene) {
  std::vector<const Volume*> emitters;
  for (const auto& volume : scene.contents().volumes) {
    if (!volume->isEmissive()) continue;
    total_ += double{volume->totalEmission().luminance()};
    bounds_ += boundsOf(*volume);
    emitters.push_back(volume.get());
  }
  if (isEmpty()) return;
  emitters_ = emitters.front();
  if (emitters.size() > 1) {
    aggregate_ = makeAggregateVolume(std::move(emitters));
    emitters_ = aggregate_.get();
  }
  findBall();
}

/// The mean of Le over points drawn by Le is Int Le^2 dV / Int Le dV.
void EmissionSampler::findBall() {
  constexpr int kPoints = 256;
  Rng rng(1);
  double mean = 0;
  for (int i = 0; i < kPoints; ++i) {
    const Vec3 p = emitters_->sampleEmission(rng);
    center_ += Vec3d(p) / double{kPoints};
    mean += double{emitters_->at(p).Le.luminance()} / kPoints;
  }
  radius2_ = mean > 0 ? sqr(std::cbrt(3 / (4 * M_PI) * total_ / mean)) : 0;
}

bool EmissionSampler::isSeldomHit(const Vec3& p) const {
  // A cone of directions with (1 - cos) / 2 = 0.15, so that sin^2 = 0.51.
  const Vec3d d = Vec3d(p) - center_;
  return radius2_ < 0.51 * dot(d, d);
}

std::optional<Vec3> EmissionSampler::sample(const Vec3& p, Vec2 u) const {
  // Choosing a voxel takes more bits than two dimensions of a sampler hold: they seed the rest.
  Rng rng(hashIntegers(std::bit_cast<std::uint32_t>(u.x), std::bit_cast<std::uint32_t>(u.y)));
  return tryNormalize(emitters_->sampleEmission(rng) - p);
}

float EmissionSampler::pdf(const Ray& ray, const MediumAlongRay& medium) const {
  double moment = medium.secondMomentOfEmission();
  Ray whole = ray;
  whole.tMax = kInfinity;
  if (ray.tMax < kInfinity)
    if (auto range = emitters_->intersect(whole); range && range->t1 > ray.tMax) {
      thread_local MediumAlongRay beyond;  // reused, so that its memory is
      range->t0 = std::max(range->t0, ray.tMax);
      beyond.assign(*emitters_, whole, *range);
      moment += beyond.secondMomentOfEmission();
    }
  return static_cast<float>(moment / total_);
}

}  // namespace brume
