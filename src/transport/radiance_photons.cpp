// SPDX-License-Identifier: Apache-2.0
#include "transport/radiance_photons.h"

#include "core/material.h"
#include "core/sampling.h"

namespace brume {
namespace {

constexpr std::int64_t kChunk = 256;
/// Least cosine between the normals.
constexpr float kMaxTilt = 0.1f;
/// Neighbours that are looked at, by and by, for one of a fitting normal.
constexpr std::size_t kFirstSearched = 4, kSearched = 256;
/// A photon's surface is found again from so far back on its way, in sizes of the scene, and must
/// lie that near to the photon.
constexpr float kStepBack = 1e-4f;
constexpr float kLargestRadius = 1e18f;  // its square is finite
/// Of the unit square, none near its rim, which is the horizon.
constexpr Vec2 kDirections[] = {
    {0.125f, 0.125f}, {0.375f, 0.625f}, {0.625f, 0.375f}, {0.875f, 0.875f}};
constexpr LobeFlags kBack = kReflection | kDiffuse | kGlossy,
                    kThrough = kTransmission | kDiffuse | kGlossy;

/// On the side of the unit vector n, of all maps.
Rgb irradiance(SurfaceInteraction at, const Vec3& n, std::span<const SurfacePhotonMap* const> maps,
               const RadianceLookup& lookup) {
  at.wo = n;
  const float reach = std::min(lookup.maxDistance, kLargestRadius);
  Rgb E;
  for (const SurfacePhotonMap* map : maps) E += map->irradianceOfNearest(at, lookup.nearest, reach);
  return E;
}

/// Hemispherical: the mean of the directional one over fixed cosine-weighted directions around the
/// unit vector `side`.
Rgb meanReflectance(const Bsdf& bsdf, const Vec3& side, LobeFlags lobes) {
  if (bsdf.countMatching(lobes) == 0) return {};
  const Frame frame = Frame::fromZ(side);
  Rgb sum;
  for (const Vec2& u : kDirections)
    sum += bsdf.reflectance(frame.fromLocal(sampleCosineHemisphere(u)), lobes);
  return sum / static_cast<float>(std::size(kDirections));
}

/// The surface on which the photon was stored, by the last part of its way, which was free.
std::optional<SurfaceInteraction> findSurface(const Scene& scene, const Photon& photon, float time,
                                              Stats& stats) {
  const float size = std::max(scene.bounds().radius(), length(photon.p));
  const Vec3 wi = photon.wi.unpack();
  const Ray ray{photon.p + kStepBack * size * wi, -wi, kInfinity, time};
  const auto hit = scene.intersect(FootprintRay(ray), stats);
  const bool isFound = hit && distance(hit->p, photon.p) < 0.1f * kStepBack * size &&
                       dot(hit->n, photon.normal()) > 0.99f;
  return isFound ? hit : std::nullopt;
}

}  // namespace

std::vector<RadiancePhotons::Site> RadiancePhotons::evaluate(
    const Scene& scene, std::span<const Photon> given,
    std::span<const SurfacePhotonMap* const> maps, const RadianceLookup& lookup, Stats& stats) {
  // Neighbours one after another: each lookup is near the last one.
  const PhotonKdTree tree(
      StridedPoints(given.empty() ? nullptr : &given.front().p, given.size(), sizeof(Photon)));
  const std::vector<Photon> photons = inOrder(given, tree.order());
  struct Chunk {
    std::vector<Site> sites;
    Stats stats;
  };
  const auto count = static_cast<std::int64_t>(photons.size());
  std::vector<Chunk> chunks(static_cast<std::size_t>((count + kChunk - 1) / kChunk));
  forEachChunk(count, kChunk, [&](std::int64_t begin, std::int64_t end, std::int64_t index) {
    Chunk& chunk = chunks[static_cast<std::size_t>(index)];
    for (std::int64_t i = begin; i < end; ++i) {
      const auto at =
          findSurface(scene, photons[static_cast<std::size_t>(i)], lookup.time, chunk.stats);
      if (!at) continue;
      Bsdf bsdf;
      at->material->evaluate(*at, bsdf);
      const Vec3 n = dot(at->wo, at->n) < 0 ? -at->n : at->n;
      const Rgb through = meanReflectance(bsdf, n, kThrough);
      const Rgb here = irradiance(*at, n, maps, lookup);
      const Rgb behind = through.isBlack() ? Rgb() : irradiance(*at, -n, maps, lookup);
      const Rgb back = meanReflectance(bsdf, n, kBack);
      chunk.sites.push_back({at->p, n, kInvPi * (back * here + through * behind)});
      if (!through.isBlack())
        chunk.sites.push_back({at->p, -n,
                               kInvPi * (meanReflectance(bsdf, -n, kBack) * behind +
                                         meanReflectance(bsdf, -n, kThrough) * here)});
    }
  });
  std::vector<Site> sites;
  for (const Chunk& chunk : chunks) {
    sites.insert(sites.end(), chunk.sites.begin(), chunk.sites.end());
    stats.merge(chunk.stats);
  }
  return sites;
}

RadiancePhotons::RadiancePhotons(std::vector<Site> sites)
    : tree_(StridedPoints(sites.empty() ? nullptr : &sites.front().p, sites.size(), sizeof(Site))),
      sites_(inOrder(std::span<const Site>(sites), tree_.order())) {
  tree_.dropOrder();
}

RadiancePhotons::RadiancePhotons(const Scene& scene, std::span<const Photon> sites,
                                 std::span<const SurfacePhotonMap* const> maps,
                                 const RadianceLookup& lookup, Stats& stats)
    : RadiancePhotons(evaluate(scene, sites, maps, lookup, stats)) {}

Rgb RadiancePhotons::radiance(const Vec3& p, const Vec3& n) const {
  std::array<Neighbour, kSearched> found;
  for (std::size_t wanted = kFirstSearched;; wanted *= 8) {
    wanted = std::min(wanted, kSearched);
    const std::size_t count = tree_.nearest(p, std::span(found).first(wanted));
    std::sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count));
    for (std::size_t i = 0; i < count; ++i) {
      const Site& site = sites_[found[i].index()];
      if (dot(site.n, n) > kMaxTilt) return site.Lo;
    }
    if (count < wanted || wanted == kSearched) return {};
  }
}

}  // namespace brume
