// SPDX-License-Identifier: Apache-2.0
#include "transport/surface_photon_map.h"

#include <array>

#include "accelerators/photon_ball.h"
#include "transport/kernels.h"
#include "transport/surface_share.h"

namespace brume {
namespace {

constexpr float kMaxTilt = 0.5f;     // cosine between the normals
constexpr float kMaxHeight = 0.25f;  // over the tangent plane, in radii
constexpr float kAsked = 0.125f;     // how often the share is asked for without a sign of an edge
constexpr float kWhole = 0.9999f;    // from this share of the disc on no edge hides photons

/// A thread's search in a map. Maps that are asked in turn have one each, most likely, so that each
/// goes on from its own last radius.
BallSearch& searchOf(const void* map) {
  constexpr std::size_t kSearches = 8;
  thread_local std::array<BallSearch, kSearches> searches;
  return searches[reinterpret_cast<std::uintptr_t>(map) / sizeof(SurfacePhotonMap) % kSearches];
}

std::vector<Photon> onSurfaces(std::span<const Photon> photons) {
  std::vector<Photon> found;
  for (const Photon& photon : photons)
    if (photon.isOnSurface()) found.push_back(photon);
  return found;
}

}  // namespace

SurfacePhotonMap::SurfacePhotonMap(std::span<const Photon> photons, const Accelerator* accelerator)
    : SurfacePhotonMap(onSurfaces(photons), accelerator) {}

SurfacePhotonMap::SurfacePhotonMap(std::vector<Photon> photons, const Accelerator* accelerator)
    : tree_(StridedPoints(photons.empty() ? nullptr : &photons.front().p, photons.size(),
                          sizeof(Photon))),
      photons_(inOrder(std::span<const Photon>(photons), tree_.order())),
      accelerator_(accelerator) {
  tree_.dropOrder();
  directions_.reserve(photons_.size());
  for (const Photon& photon : photons_)
    directions_.push_back({photon.wi.unpack(), photon.normal()});
}

/// One estimate in the making: sum_i lightOf(photon_i, directions_i) K2(d_i; r) over the part of
/// the disc that is there.
template <class LightOf>
struct SurfacePhotonMap::Disc {
  const SurfacePhotonMap& map;
  const SurfaceInteraction& at;
  const LightOf& lightOf;
  float radius2, radius = std::sqrt(radius2);
  DiscKernel kernel{radius2};

  bool isOfSurface(std::uint32_t i) const {
    return dot(map.directions_[i].n, at.n) >= kMaxTilt &&
           absDot(map.photons_[i].p - at.p, at.n) <= kMaxHeight * radius;
  }
  Rgb light(std::uint32_t i, float d2) const {
    return lightOf(map.photons_[i], map.directions_[i]) * kernel(d2);
  }

  /// `forEach` calls its argument with every photon in reach and its squared distance.
  template <class ForEach>
  Rgb sum(ForEach forEach) const {
    const Accelerator* const accelerator = map.accelerator_;
    Rgb all;
    bool hasOthers = false;  // photons of other surfaces: an edge may be near
    forEach([&](std::uint32_t i, float d2) {
      if (isOfSurface(i))
        all += light(i, d2);
      else
        hasOthers = true;
    });
    if (!accelerator || all.isBlack()) return all;
    const float slab = kMaxHeight * radius;
    if (!hasOthers) {
      // An edge whose other side is dark: asked for rarely, by chance, and then counted for all.
      if (chanceOf(at.p) >= kAsked) return all;
      return all * (1 + (1 / surfaceShare(*accelerator, at, radius, slab) - 1) / kAsked);
    }
    const float share = surfaceShare(*accelerator, at, radius, slab);
    if (share > kWhole) return all / share;
    Rgb inSight;
    forEach([&](std::uint32_t i, float d2) {
      if (isOfSurface(i) && !isBehindAnEdge(*accelerator, at, map.photons_[i].p, slab))
        inSight += light(i, d2);
    });
    return inSight / share;
  }
};

template <class LightOf>
Rgb SurfacePhotonMap::ofNearest(const SurfaceInteraction& at, std::size_t k, float maxRadius,
                                const LightOf& lightOf) const {
  // With fewer than k photons it is the reach that must set the radius.
  if (tree_.size() < k && !std::isfinite(sqr(maxRadius))) return {};
  BallSearch& search = searchOf(this);
  const float radius2 = search.radius2OfNearest(tree_, at.p, k, maxRadius);
  if (!(radius2 > 0) || !std::isfinite(radius2)) return {};
  const Disc<LightOf> disc{*this, at, lightOf, radius2};
  return disc.sum([&](auto&& use) {
    for (std::size_t i = 0; i < search.size(); ++i)
      if (search.distances2()[i] < radius2) use(search.indices()[i], search.distances2()[i]);
  });
}

namespace {

/// From here on (cosine) two normals are one, but for the rounding of the photon's.
constexpr float kSamePlane = 0.99999f;

/// Whether two directions are on the same side of a plane, neither in it.
bool areOnOneSide(float cosineA, float cosineB) {
  return cosineA > 0 ? cosineB > 0 : cosineA < 0 && cosineB < 0;
}

/// f alpha with the cosines, as a function of the photon: its power is counted per area of the
/// surface where it lies, which on a curved object is not the one of `at`.
auto scatteredBy(const SurfaceInteraction& at, const Bsdf& bsdf) {
  return [&, constant = bsdf.constantReflection(kNonSpecular),
          cosineOut = dot(at.wo, bsdf.geometricNormal())](const Photon& photon,
                                                          const auto& directions) -> Rgb {
    const Vec3 &wi = directions.wi, &n = directions.n;
    const auto constantAt = [&] {
      return areOnOneSide(cosineOut, dot(wi, bsdf.geometricNormal())) ? *constant : Rgb();
    };
    const Rgb f = constant ? constantAt() : bsdf.f(at.wo, wi, kNonSpecular);
    const float geometric = absDot(wi, dot(n, at.n) > kSamePlane ? at.n : n);
    if (f.isBlack() || !(geometric > 0)) return {};
    return f * photon.power * (absDot(wi, bsdf.shadingNormal()) / geometric);
  };
}

}  // namespace

Rgb SurfacePhotonMap::radiance(const SurfaceInteraction& at, const Bsdf& bsdf, float radius) const {
  if (!(sqr(radius) > 0)) return {};
  const auto lightOf = scatteredBy(at, bsdf);
  const Disc<decltype(lightOf)> disc{*this, at, lightOf, sqr(radius)};
  return disc.sum([&](auto&& use) { tree_.forEachWithin(at.p, sqr(radius), use); });
}

Rgb SurfacePhotonMap::radianceOfNearest(const SurfaceInteraction& at, const Bsdf& bsdf,
                                        std::size_t k, float maxRadius) const {
  return ofNearest(at, k, maxRadius, scatteredBy(at, bsdf));
}

Rgb SurfacePhotonMap::irradianceOfNearest(const SurfaceInteraction& at, std::size_t k,
                                          float maxRadius) const {
  const Vec3 side = dot(at.n, at.wo) < 0 ? -at.n : at.n;
  return ofNearest(at, k, maxRadius,
                   [&](const Photon& photon, const Directions& directions) -> Rgb {
                     return dot(directions.wi, side) > 0 ? photon.power : Rgb();
                   });
}

}  // namespace brume
