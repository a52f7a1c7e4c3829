// SPDX-License-Identifier: Apache-2.0
#include "transport/surface_photon_map.h"

#include "transport/kernels.h"

namespace brume {
namespace {

constexpr float kMaxTilt = 0.5f;     // cosine between the normals
constexpr float kMaxHeight = 0.25f;  // over the tangent plane, in radii

std::vector<Photon> onSurfaces(std::span<const Photon> photons) {
  std::vector<Photon> found;
  for (const Photon& photon : photons)
    if (photon.isOnSurface()) found.push_back(photon);
  return found;
}

}  // namespace

SurfacePhotonMap::SurfacePhotonMap(std::span<const Photon> photons)
    : SurfacePhotonMap(onSurfaces(photons)) {}

SurfacePhotonMap::SurfacePhotonMap(std::vector<Photon> photons)
    : tree_(StridedPoints(photons.empty() ? nullptr : &photons.front().p, photons.size(),
                          sizeof(Photon))),
      photons_(inOrder(std::span<const Photon>(photons), tree_.order())) {
  tree_.dropOrder();
}

/// f alpha with the cosines; black for a photon of another surface.
Rgb SurfacePhotonMap::contribution(const SurfaceInteraction& at, const Bsdf& bsdf,
                                   std::uint32_t index, float radius) const {
  const Photon& photon = photons_[index];
  if (dot(photon.normal(), at.n) < kMaxTilt) return {};
  if (absDot(photon.p - at.p, at.n) > kMaxHeight * radius) return {};
  const Vec3 wi = photon.wi.unpack();
  const Rgb f = bsdf.f(at.wo, wi, kNonSpecular);
  const float geometric = absDot(wi, bsdf.geometricNormal());
  if (f.isBlack() || !(geometric > 0)) return {};
  return f * photon.power * (absDot(wi, bsdf.shadingNormal()) / geometric);
}

Rgb SurfacePhotonMap::radiance(const SurfaceInteraction& at, const Bsdf& bsdf, float radius) const {
  const float radius2 = sqr(radius);
  if (!(radius2 > 0)) return {};
  const DiscKernel kernel(radius2);
  Rgb L;
  tree_.forEachWithin(at.p, radius2, [&](std::uint32_t i, float d2) {
    L += contribution(at, bsdf, i, radius) * kernel(d2);
  });
  return L;
}

Rgb SurfacePhotonMap::radianceOfNearest(const SurfaceInteraction& at, const Bsdf& bsdf,
                                        std::size_t k, float maxRadius) const {
  thread_local std::vector<Neighbour> found;  // reused, so that its memory is
  found.resize(k);
  const std::size_t n = tree_.nearest(at.p, found, maxRadius);
  const bool isFull = n == k;
  const float radius2 = isFull ? found.front().distance2() : sqr(maxRadius);
  if (n == 0 || !(radius2 > 0) || !std::isfinite(radius2)) return {};
  const DiscKernel kernel(radius2);
  const float radius = std::sqrt(radius2);
  Rgb L;
  for (std::size_t i = isFull ? 1 : 0; i < n; ++i)
    L += contribution(at, bsdf, found[i].index(), radius) * kernel(found[i].distance2());
  return L;
}

}  // namespace brume
