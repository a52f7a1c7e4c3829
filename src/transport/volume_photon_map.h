// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "accelerators/photon_bvh.h"
#include "core/medium_along_ray.h"
#include "transport/photon.h"

namespace brume {

/// The photons in the scene's media, for the estimates of light that is scattered towards a viewer.
/// Memory per photon: 12 bytes of position, 3.5 of boxes, 16 of power and direction. Immutable and
/// thread-safe. Test: volume_photon_map_test.
class VolumePhotonMap {
 public:
  /// Whether powers are what arrives at a photon, or what is scattered there (times the albedo).
  enum class Power { Arriving, Scattered };

  /// Takes the volume photons among those given; photons without (scattered) power are left out.
  VolumePhotonMap(const Volume& volume, std::span<const Photon> photons, Power power);

  std::size_t size() const { return tree_.size(); }
  const PhotonKdTree& tree() const { return tree_; }
  const Volume& volume() const { return volume_; }
  const Rgb& power(std::size_t i) const { return stored_[i].power; }
  /// To where the light comes from.
  Vec3 wi(std::size_t i) const { return stored_[i].wi.unpack(); }
  /// The phase function is 1/(4 pi) everywhere.
  bool isIsotropic() const { return isIsotropic_; }
  std::size_t memoryBytes() const { return tree_.memoryBytes() + stored_.size() * sizeof(Stored); }

 private:
  struct Stored {
    Rgb power;
    PackedDirection wi;
  };
  struct Selection;
  VolumePhotonMap(const Volume& volume, const Selection& selection);

  const Volume& volume_;
  bool isIsotropic_;
  PhotonKdTree tree_;
  std::vector<Stored> stored_;  // in the order of the tree
};

/// Beam radiance estimate along the whole range of a medium: all photons whose disc the ray
/// crosses,
///   Lv = sum_i Tr(t0, t_i) f_p(w_i, w) albedo(x_i) alpha_i K2(d_i; r_i)      [W m^-2 sr^-1]
/// The map holds scattered powers. Source: Jarosz, Zwicker, Jensen 2008.
struct BeamEstimate {
  Rgb L;
  std::uint64_t photons = 0;
};
BeamEstimate beamRadiance(const VolumePhotonMap& map, const PhotonBvh& bvh,
                          const MediumAlongRay& medium);

/// How the photons around a point are chosen.
struct PointLookup {
  std::size_t nearest = 0;   ///< k; 0: all within radius
  float radius = kInfinity;  ///< of the lookup; with k: the largest
};

/// In-scattered light at a point per sigma_t, by the photons around it,
///   sum_{i in N(p)} f_p(w_i, w) alpha_i K3(d_i; r)                           [W m^-3 sr^-1]
/// k nearest: r is the distance to the k-th, which does not count itself, so that the density is
/// unbiased where it is even; fewer than k within the radius: all of them, with the radius. The map
/// holds arriving powers. `scratch` keeps its memory from call to call.
BeamEstimate pointRadiance(const VolumePhotonMap& map, const PointLookup& lookup, const Vec3& p,
                           const Vec3& wo, std::vector<Neighbour>& scratch);

}  // namespace brume
