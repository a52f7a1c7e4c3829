// SPDX-License-Identifier: Apache-2.0
#include "transport/final_gather.h"

#include "core/material.h"
#include "core/sampling.h"

namespace brume {
namespace {

/// Photons around whose directions the cones lie.
constexpr std::size_t kCones = 50;
constexpr LobeFlags kSpecularLobes = kReflection | kTransmission | kSpecular;

}  // namespace

/// Cones around the directions from which photons came, as a density of directions.
class FinalGather::Cones {
 public:
  Cones(const SurfacePhotonMap& map, const Vec3& p, float cosAngle)
      : cosAngle_(cosAngle), inverseSolidAngle_(1 / (2 * kPi * (1 - cosAngle))) {
    std::array<Neighbour, kCones> found;
    count_ = map.tree().nearest(p, found);
    for (std::size_t i = 0; i < count_; ++i) axes_[i] = map.photons()[found[i].index()].wi.unpack();
  }
  bool isEmpty() const { return count_ == 0; }

  Vec3 sample(float uCone, Vec2 u) const {
    const auto i =
        std::min(count_ - 1, static_cast<std::size_t>(uCone * static_cast<float>(count_)));
    const float z = 1 - u.x * (1 - cosAngle_);
    const float r = std::sqrt(std::max(0.f, 1 - z * z)), phi = 2 * kPi * u.y;
    return Frame::fromZ(axes_[i]).fromLocal({r * std::cos(phi), r * std::sin(phi), z});
  }
  /// Per solid angle.
  float pdf(const Vec3& w) const {
    std::size_t hits = 0;
    for (std::size_t i = 0; i < count_; ++i) hits += dot(axes_[i], w) >= cosAngle_ ? 1 : 0;
    return inverseSolidAngle_ * static_cast<float>(hits) / static_cast<float>(count_);
  }

 private:
  std::array<Vec3, kCones> axes_;
  std::size_t count_ = 0;
  float cosAngle_, inverseSolidAngle_;
};

/// Radiance along -wi, through mirrors and glass, attenuated by the media on the way.
Rgb FinalGather::arriving(const SurfaceQuery& query, const Vec3& wi, RenderContext& context) const {
  Rgb L, weight(1.f);
  Ray ray = query.hit.spawnRay(wi);
  for (int bounces = 0;; ++bounces) {
    const auto hit = scene_.intersect(FootprintRay(ray), context.stats);
    if (!hit) return L;
    if (scene_.volume()) {
      ray.tMax = distance(ray.o, hit->p);
      weight *= query.media.transmittance(ray, context);
    }
    if (hit->material->hasNonSpecular())
      L += weight * radiance_.radiance(hit->p, dot(hit->n, hit->wo) < 0 ? -hit->n : hit->n);
    if (!hit->material->hasSpecular() || bounces == settings_.maxBounces) return L;

    // One of the specular lobes, and roulette.
    Bsdf bsdf;
    hit->material->evaluate(*hit, bsdf);
    const float uLobe = context.samples.get1D(), uSurvival = context.samples.get1D();
    const auto sample = bsdf.sample(hit->wo, uLobe, Vec2(0.5f), kSpecularLobes);
    if (!sample || !(sample->pdf > 0)) return L;
    weight *= sample->f * (absDot(sample->wi, bsdf.shadingNormal()) / sample->pdf);
    const float survival = std::min(1.f, weight.maxChannel());
    if (uSurvival >= survival) return L;
    weight /= survival;
    ray = hit->spawnRay(sample->wi);
  }
}

Rgb FinalGather::reflected(const SurfaceQuery& query, const Bsdf& bsdf,
                           RenderContext& context) const {
  const Vec3& wo = query.hit.wo;
  const Cones cones(indirect_, query.hit.p, settings_.cosAngle);
  thread_local std::vector<Vec2> u2;  // reused, so that their memory is
  thread_local std::vector<float> u1;
  const auto n = static_cast<std::size_t>(settings_.samples);
  const auto draw = [&] {
    u1.resize(n);
    u2.resize(n);
    context.samples.get1DArray(u1);
    context.samples.get2DArray(u2);
  };
  const auto cosine = [&](const Vec3& wi) { return absDot(wi, bsdf.shadingNormal()); };

  // Directions of the BSDF.
  Rgb L;
  draw();
  for (std::size_t i = 0; i < n; ++i) {
    const auto sample = bsdf.sample(wo, u1[i], u2[i], kNonSpecular);
    if (!sample || !(sample->pdf > 0) || sample->f.isBlack()) continue;
    const float weight = cones.isEmpty() ? 1.f : powerHeuristic(sample->pdf, cones.pdf(sample->wi));
    if (!(weight > 0)) continue;
    L += sample->f * arriving(query, sample->wi, context) *
         (cosine(sample->wi) * weight / sample->pdf);
  }

  // Directions from which photons came.
  if (!cones.isEmpty()) {
    draw();
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 wi = cones.sample(u1[i], u2[i]);
      const float pdf = cones.pdf(wi);
      const BsdfValue value = bsdf.evaluate(wo, wi, kNonSpecular);
      if (value.f.isBlack() || !(pdf > 0)) continue;  // pdf 0: at the rim, by rounding
      L += value.f * arriving(query, wi, context) *
           (cosine(wi) * powerHeuristic(pdf, value.pdf) / pdf);
    }
  }
  return L / static_cast<float>(n);
}

}  // namespace brume
