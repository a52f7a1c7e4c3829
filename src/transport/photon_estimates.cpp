// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_estimates.h"

#include "core/lanes_math.h"
#include "transport/depth_tables.h"
#include "transport/kernels.h"

namespace brume {
namespace {

/// A sum of many terms, in double.
struct RgbSum {
  double r = 0, g = 0, b = 0;
  void add(const Rgb& c) { r += double{c.r}, g += double{c.g}, b += double{c.b}; }
  Rgb times(double factor) const {
    return {static_cast<float>(r * factor), static_cast<float>(g * factor),
            static_cast<float>(b * factor)};
  }
};

/// A sum in each lane, of so few terms that float is enough.
struct LaneSums {
  alignas(32) std::array<std::array<float, kLanes>, 3> L{};

  RgbSum& addTo(RgbSum& sum) const {
    for (std::size_t i = 0; i < kLanes; ++i) sum.add({L[0][i], L[1][i], L[2][i]});
    return sum;
  }
};

/// The Henyey-Greenstein phase function towards a viewer, as a constant times
///   ((1 - a)^2 + a |d + sign wi|^2)^(-3/2),   a = |g|
/// d the direction of the viewer's ray, wi to where the light comes from.
struct Viewer {
  Vec3 d;
  float a, sign, oneMinusA2;
  double factor;

  Viewer(const Vec3& rayDirection, float g)
      : d(rayDirection),
        a(std::abs(g)),
        sign(g < 0 ? 1.f : -1.f),
        oneMinusA2(sqr(1.f - a)),
        factor(double{kInv4Pi} * (1 - double{a}) * (1 + double{a})) {}
};

/// Optical depths along a beam: sigma_t (t - t0), or known for each photon of a batch.
struct BeamDepths {
  using Known = std::array<std::array<float, PhotonKdTree::kBatch + kLanes>, 3>;
  float t0 = 0;
  std::array<float, 3> sigma_t{};
  bool isGrey = false;  ///< the first channel's hold for all
  const Known* known = nullptr;
};

#define BRUME_KERNELS "transport/photon_scatter.inl"
#include "core/both_lanes.inl"

/// g of all of a map's media.
std::optional<float> phaseOf(const VolumePhotonMap& map) {
  return map.isIsotropic() ? std::optional(0.f) : map.volume().henyeyGreenstein();
}

/// Power times phase function, for any medium.
Rgb turned(const VolumePhotonMap& map, std::size_t photon, const Vec3& p, const Vec3& wo) {
  const Rgb power = map.power(photon);
  return map.isIsotropic() ? power * kInv4Pi : power * map.volume().phase(p, wo, map.wi(photon));
}

/// Without the known ones.
BeamDepths depthsOf(const VolumePhotonMap& map, const MediumAlongRay& medium) {
  BeamDepths depths;
  depths.t0 = medium.range().t0;
  depths.isGrey = medium.isGrey();
  if (const auto uniform = map.volume().uniform()) {
    const Rgb sigma_t = uniform->coefficients.sigma_t();
    depths.sigma_t = {sigma_t.r, sigma_t.g, sigma_t.b};
  }
  return depths;
}

/// Optical depths along one beam, looked up for batch after batch: in a table, once there were so
/// many photons that it pays.
class DepthsAlongBeam {
 public:
  explicit DepthsAlongBeam(const MediumAlongRay& medium) : medium_(medium) { table().reset(1); }

  void find(const PhotonBvh::Found& batch, std::size_t count, BeamDepths::Known& known) {
    DepthTables& table = DepthsAlongBeam::table();
    photons_ += count;
    if (!isFilled_ && kSpansPerPhoton * photons_ > medium_.spans().size()) {
      table.fill(0, medium_, medium_.range().t0);
      isFilled_ = true;
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (isFilled_) {
        const auto depth = table.at(0, batch.t[i] - medium_.range().t0);
        for (std::size_t c = 0; c < 3; ++c) known[c][i] = depth.of[c];
      } else {
        const Vec3d depth = medium_.depthAt(double{batch.t[i]});
        for (std::size_t c = 0; c < 3; ++c)
          known[c][i] = static_cast<float>(depth[static_cast<int>(c)]);
      }
    }
  }

 private:
  /// Spans that a table takes in the time in which one photon's depth is found without.
  static constexpr std::size_t kSpansPerPhoton = 2;
  static DepthTables& table() {
    thread_local DepthTables table;  // reused, so that its memory is
    return table;
  }
  const MediumAlongRay& medium_;
  std::size_t photons_ = 0;
  bool isFilled_ = false;
};

/// Fills the last row of a batch with copies that do not count.
void completeRow(PhotonBvh::Found& batch, std::size_t count) {
  for (std::size_t i = count; i % kLanes != 0; ++i) {
    batch.indices[i] = batch.indices[0];
    batch.t[i] = batch.t[0];
    batch.distances2[i] = batch.radii2[i] = 1;  // the kernel's rim
  }
}

/// The estimate where the phase function is Henyey and Greenstein's.
BeamEstimate beamRadianceInLanes(const VolumePhotonMap& map, const PhotonBvh& bvh,
                                 const MediumAlongRay& medium, const Viewer& viewer) {
  const Ray& ray = medium.ray();
  BeamDepths depths = depthsOf(map, medium);
  BeamDepths::Known known{};
  std::optional<DepthsAlongBeam> varying;
  if (!map.volume().uniform()) {
    depths.known = &known;
    varying.emplace(medium);
  }
  RgbSum sum;
  std::uint64_t photons = 0;
  bvh.forEachBatchInBeam({ray.o, ray.d, medium.range()},
                         [&](PhotonBvh::Found& batch, std::size_t count) {
                           completeRow(batch, count);
                           if (varying) varying->find(batch, count, known);
                           LaneSums some;
                           if (hasAvx2())
                             avx2::addBeam(map.rows(), viewer, depths, batch, count, some);
                           else
                             generic::addBeam(map.rows(), viewer, depths, batch, count, some);
                           some.addTo(sum);
                           photons += count;
                         });
  return {sum.times(viewer.factor * 3 / M_PI), photons};
}

}  // namespace

BeamEstimate beamRadiance(const VolumePhotonMap& map, const PhotonBvh& bvh,
                          const MediumAlongRay& medium) {
  const Ray& ray = medium.ray();
  if (const auto g = phaseOf(map)) return beamRadianceInLanes(map, bvh, medium, Viewer(ray.d, *g));
  const Vec3 wo = -ray.d;
  RgbSum sum;
  std::uint64_t count = 0;
  bvh.forEachInBeam({ray.o, ray.d, medium.range()}, [&](std::uint32_t i, BeamFoot<float> foot) {
    const float kernel = DiscKernel(bvh.radius2(i))(foot.d2);
    sum.add(medium.transmittance(foot.t) * turned(map, i, map.tree().point(i), wo) * kernel);
    ++count;
  });
  return {sum.times(1), count};
}

namespace {

/// Leaves out the photons that are not between the planes; returns how many are left.
std::size_t keepBetween(const PhotonKdTree& tree, const Vec3& p, const Vec3& along,
                        Interval between, BallSearch& search, std::size_t count) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t index = search.indices()[i];
    const float s = dot(tree.point(index) - p, along);
    search.indices()[kept] = index;
    search.distances2()[kept] = search.distances2()[i];
    kept += s >= between.t0 && s <= between.t1 ? 1 : 0;
  }
  return kept;
}

}  // namespace

BeamEstimate pointRadiance(const VolumePhotonMap& map, const PointLookup& lookup, const Vec3& p,
                           const Vec3& wo, BallSearch& search) {
  float radius2 = sqr(lookup.radius);
  if (lookup.nearest == 0)
    search.findWithin(map.tree(), p, radius2);
  else
    radius2 = search.radius2OfNearest(map.tree(), p, lookup.nearest, lookup.radius);
  if (!(radius2 > 0)) return {};

  // The same photons in the same order, however they were found.
  std::uint32_t* const indices = search.indices();
  float* const distances2 = search.distances2();
  std::size_t count = hasAvx2() ? avx2::keepNearer(radius2, indices, distances2, search.size())
                                : generic::keepNearer(radius2, indices, distances2, search.size());
  // The part of the kernel that counts.
  double part = 1;
  const float radius = std::sqrt(radius2);
  if (lookup.between.t0 > -radius || lookup.between.t1 < radius) {
    count = keepBetween(map.tree(), p, -wo, lookup.between, search, count);
    part = double{ballKernelBefore(lookup.between.t1 / radius)} -
           double{ballKernelBefore(lookup.between.t0 / radius)};
    if (!(part > 0)) return {};
  }
  RgbSum sum;
  if (const auto g = phaseOf(map)) {
    const Viewer viewer(-wo, *g);
    constexpr std::size_t kInFloat = 1024;  // terms added in float: 128 in each lane
    for (std::size_t i = 0; i < count; i += kInFloat) {
      const std::size_t n = std::min(kInFloat, count - i);
      for (std::size_t j = i + n; j % kLanes != 0; ++j) indices[j] = 0, distances2[j] = radius2;
      LaneSums some;
      if (hasAvx2())
        avx2::addPoint(map.rows(), viewer, indices + i, distances2 + i, n, 1 / radius2, some);
      else
        generic::addPoint(map.rows(), viewer, indices + i, distances2 + i, n, 1 / radius2, some);
      some.addTo(sum);
    }
    return {sum.times(viewer.factor * double{BallKernel(radius2)(0)} / part), count};
  }
  const BallKernel kernel(radius2);
  for (std::size_t i = 0; i < count; ++i)
    sum.add(turned(map, indices[i], p, wo) * kernel(distances2[i]));
  return {sum.times(1 / part), count};
}

}  // namespace brume
