// SPDX-License-Identifier: Apache-2.0
#include "transport/specular.h"

namespace brume {
namespace {

/// Bounces at which both reflection and refraction are followed: PBRT-v2's default depth of 5 stays
/// a full tree of at most 16 paths.
constexpr int kSplitDepth = 4;

/// Change of the outgoing direction with that of the incoming one and of the normal, to the
/// neighbouring sample.
struct Neighbour {
  Vec3 dwo;  ///< change of wo
  Vec3 dn;   ///< change of the normal, which lies on the side of wo
};

/// d(2 (wo.n) n - wo)
Vec3 reflectedChange(const Vec3& wo, const Vec3& n, const Neighbour& d) {
  const float dCos = dot(d.dwo, n) + dot(wo, d.dn);
  return 2.f * (dot(wo, n) * d.dn + dCos * n) - d.dwo;
}

/// d(-eta wo + mu n), mu = eta cos_o - cos_t, cos_t^2 = 1 - eta^2 (1 - cos_o^2)
Vec3 refractedChange(const Vec3& wo, const Vec3& wi, const Vec3& n, float eta, const Neighbour& d) {
  const float cosO = dot(wo, n), cosT = -dot(wi, n);
  const float dCos = dot(d.dwo, n) + dot(wo, d.dn);
  const float mu = eta * cosO - cosT;
  const float dMu = cosT > 0 ? (eta - eta * eta * cosO / cosT) * dCos : 0.f;
  return mu * d.dn + dMu * n - eta * d.dwo;
}

}  // namespace

FootprintRay specularRay(const FootprintRay& incoming, const SurfaceInteraction& at,
                         const Vec3& shadingNormal, const BsdfSample& sample) {
  FootprintRay ray(at.spawnRay(sample.wi));
  if (!incoming.differential) return ray;
  const TextureContext& t = at.texture;
  const float side = dot(at.wo, shadingNormal) < 0 ? -1.f : 1.f;
  const Vec3 n = side * shadingNormal;
  const auto change = [&](const Vec3& neighbourDirection, float du, float dv) {
    const Neighbour d{-neighbourDirection - at.wo,
                      side * (at.shading.dndu * du + at.shading.dndv * dv)};
    return sample.isTransmission() ? refractedChange(at.wo, sample.wi, n, sample.eta, d)
                                   : reflectedChange(at.wo, n, d);
  };
  const RayDifferential& in = *incoming.differential;
  const Vec3 dwx = change(in.rxDirection, t.dudx, t.dvdx);
  const Vec3 dwy = change(in.ryDirection, t.dudy, t.dvdy);
  // A footprint that grazing refraction blew up beyond any use is dropped.
  if (!isFinite(dwx) || !isFinite(dwy)) return ray;
  ray.differential =
      RayDifferential{ray.o + t.dpdx, ray.o + t.dpdy, sample.wi + dwx, sample.wi + dwy};
  return ray;
}

namespace {

Rgb bounceWeight(const BsdfSample& sample, const Bsdf& bsdf) {
  return sample.f * (absDot(sample.wi, bsdf.shadingNormal()) / sample.pdf);
}

std::optional<BsdfSample> sampleSpecular(const SurfaceQuery& query, const Bsdf& bsdf,
                                         LobeFlags lobes, RenderContext& context) {
  if (bsdf.countMatching(lobes) == 0) return std::nullopt;
  const float uLobe = context.samples.get1D();
  auto sample = bsdf.sample(query.hit.wo, uLobe, Vec2(0.5f), lobes);
  if (!sample || !(sample->pdf > 0) || sample->f.isBlack()) return std::nullopt;
  return sample;
}

Rgb follow(const SurfaceQuery& query, const Bsdf& bsdf, const BsdfSample& sample,
           RenderContext& context) {
  return query.radiance.Li(specularRay(query.ray, query.hit, bsdf.shadingNormal(), sample),
                           query.depth + 1, context);
}

}  // namespace

Rgb specularRadiance(const SurfaceQuery& query, const Bsdf& bsdf, int maxDepth,
                     RenderContext& context) {
  if (query.depth + 1 >= maxDepth) return {};
  if (query.depth < kSplitDepth) {
    Rgb L;
    for (const LobeFlags side : {kReflection, kTransmission}) {
      const auto sample = sampleSpecular(query, bsdf, side | kSpecular, context);
      if (sample) L += bounceWeight(*sample, bsdf) * follow(query, bsdf, *sample, context);
    }
    return L;
  }
  const auto sample = sampleSpecular(query, bsdf, kReflection | kTransmission | kSpecular, context);
  if (!sample) return {};
  const Rgb weight = bounceWeight(*sample, bsdf);
  const float survival = std::min(1.f, weight.maxChannel());
  if (context.samples.get1D() >= survival) {
    context.stats.add(Stat::RussianRouletteStops);
    return {};
  }
  return weight / survival * follow(query, bsdf, *sample, context);
}

}  // namespace brume
