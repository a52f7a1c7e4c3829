// SPDX-License-Identifier: Apache-2.0
#include "transport/volume_photon_map.h"

#include "transport/free_flight.h"
#include "transport/kernels.h"

namespace brume {

/// The photons that are kept, in the order in which they were given.
struct VolumePhotonMap::Selection {
  std::vector<Vec3> points;
  std::vector<Stored> stored;

  Selection(const Volume& volume, std::span<const Photon> photons, Power power) {
    for (const Photon& photon : photons) {
      if (photon.isOnSurface()) continue;
      const Rgb kept =
          power == Power::Arriving ? photon.power : photon.power * albedoOf(volume.at(photon.p));
      if (kept.isBlack()) continue;
      points.push_back(photon.p);
      stored.push_back({kept, photon.wi});
    }
  }
};

VolumePhotonMap::VolumePhotonMap(const Volume& volume, std::span<const Photon> photons, Power power)
    : VolumePhotonMap(volume, Selection(volume, photons, power)) {}

VolumePhotonMap::VolumePhotonMap(const Volume& volume, const Selection& selection)
    : volume_(volume),
      // A density over the sphere whose largest value is its mean is constant.
      isIsotropic_(volume.phasePeak() <= kInv4Pi * (1 + 1e-6f)),
      tree_(std::span<const Vec3>(selection.points)),
      stored_(inOrder(std::span<const Stored>(selection.stored), tree_.order())) {
  tree_.dropOrder();
}

namespace {

/// A sum of many terms, in double.
struct RgbSum {
  double r = 0, g = 0, b = 0;
  void add(const Rgb& c) { r += double{c.r}, g += double{c.g}, b += double{c.b}; }
  Rgb total() const {
    return {static_cast<float>(r), static_cast<float>(g), static_cast<float>(b)};
  }
};

/// Power times phase function.
Rgb turned(const VolumePhotonMap& map, std::size_t photon, const Vec3& p, const Vec3& wo) {
  const Rgb& power = map.power(photon);
  return map.isIsotropic() ? power * kInv4Pi : power * map.volume().phase(p, wo, map.wi(photon));
}

}  // namespace

BeamEstimate beamRadiance(const VolumePhotonMap& map, const PhotonBvh& bvh,
                          const MediumAlongRay& medium) {
  const Ray& ray = medium.ray();
  const Vec3 wo = -ray.d;
  RgbSum sum;
  std::uint64_t count = 0;
  bvh.forEachInBeam({ray.o, ray.d, medium.range()}, [&](std::uint32_t i, BeamFoot<float> foot) {
    const float kernel = DiscKernel(bvh.radius2(i))(foot.d2);
    sum.add(medium.transmittance(foot.t) * turned(map, i, map.tree().point(i), wo) * kernel);
    ++count;
  });
  return {sum.total(), count};
}

BeamEstimate pointRadiance(const VolumePhotonMap& map, const PointLookup& lookup, const Vec3& p,
                           const Vec3& wo, std::vector<Neighbour>& scratch) {
  RgbSum sum;
  std::uint64_t count = 0;
  const auto add = [&](std::uint32_t i, float kernel) {
    sum.add(turned(map, i, p, wo) * kernel);
    ++count;
  };
  const auto addAllWithin = [&](float radius2) {
    const BallKernel kernel(radius2);
    map.tree().forEachWithin(p, radius2, [&](std::uint32_t i, float d2) { add(i, kernel(d2)); });
    return BeamEstimate{sum.total(), count};
  };
  if (lookup.nearest == 0) return addAllWithin(sqr(lookup.radius));

  // The k-th stands in front.
  scratch.resize(lookup.nearest);
  const std::size_t found = map.tree().nearest(p, scratch, lookup.radius);
  if (found < lookup.nearest && lookup.radius < kInfinity) return addAllWithin(sqr(lookup.radius));
  if (found < 2 || !(scratch[0].distance2() > 0)) return {};
  const BallKernel kernel(scratch[0].distance2());
  for (const Neighbour& n : std::span(scratch).first(found).subspan(1))
    add(n.index(), kernel(n.distance2()));
  return {sum.total(), count};
}

}  // namespace brume
