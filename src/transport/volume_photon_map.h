// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "accelerators/photon_kdtree.h"
#include "core/volume.h"
#include "transport/photon.h"

namespace brume {

/// The photons in the scene's media, for the estimates of light that is scattered towards a viewer.
/// Memory per photon: 12 bytes of position, 3.5 of boxes, 16 of power and direction. Immutable and
/// thread-safe. What is read off it: photon_estimates.h. Test: photon_estimates_test.
class VolumePhotonMap {
 public:
  /// Whether powers are what arrives at a photon, or what is scattered there (times the albedo).
  enum class Power { Arriving, Scattered };

  /// Takes the volume photons among those given, and, of scattered powers, their mirror images
  /// (PhotonMirror) for kernels of a radius; photons without (scattered) power are left out.
  VolumePhotonMap(const Volume& volume, std::span<const Photon> photons, Power power,
                  float mirrorRadius = 0);

  std::size_t size() const { return tree_.size(); }
  const PhotonKdTree& tree() const { return tree_; }
  const Volume& volume() const { return volume_; }
  Rgb power(std::size_t i) const { return {rows_[i][0], rows_[i][1], rows_[i][2]}; }
  /// To where the light comes from.
  Vec3 wi(std::size_t i) const {
    return PackedDirection::fromBits(std::bit_cast<std::uint32_t>(rows_[i][3])).unpack();
  }
  /// Of each photon the power, then the bits of wi.
  const float* rows() const { return rows_.front().data(); }
  /// The phase function is 1/(4 pi) everywhere.
  bool isIsotropic() const { return isIsotropic_; }
  std::size_t memoryBytes() const { return tree_.memoryBytes() + rows_.size() * sizeof(Row); }

 private:
  using Row = std::array<float, 4>;
  struct Selection;
  VolumePhotonMap(const Volume& volume, const Selection& selection);

  const Volume& volume_;
  bool isIsotropic_;
  PhotonKdTree tree_;
  std::vector<Row> rows_;  // in the order of the tree
};

}  // namespace brume
