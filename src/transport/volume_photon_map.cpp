// SPDX-License-Identifier: Apache-2.0
#include "transport/volume_photon_map.h"

#include "transport/free_flight.h"
#include "transport/photon_mirror.h"

namespace brume {

/// The photons that are kept, in the order in which they were given.
struct VolumePhotonMap::Selection {
  std::vector<Vec3> points;
  std::vector<Row> rows;

  Selection(const Volume& volume, std::span<const Photon> photons, Power power,
            float mirrorRadius) {
    const PhotonMirror mirror(volume);
    for (const Photon& photon : photons) {
      if (photon.isOnSurface()) continue;
      const Rgb kept =
          power == Power::Arriving ? photon.power : photon.power * albedoOf(volume.at(photon.p));
      if (kept.isBlack()) continue;
      const auto add = [&](const Vec3& p, const Rgb& share) {
        const Rgb imaged = kept * share;
        points.push_back(p);
        rows.push_back({imaged.r, imaged.g, imaged.b, std::bit_cast<float>(photon.wi.bits())});
      };
      add(photon.p, Rgb(1.f));
      if (mirrorRadius > 0 && power == Power::Scattered)
        mirror.forEachImage(photon.p, mirrorRadius, add);
    }
  }
};

VolumePhotonMap::VolumePhotonMap(const Volume& volume, std::span<const Photon> photons, Power power,
                                 float mirrorRadius)
    : VolumePhotonMap(volume, Selection(volume, photons, power, mirrorRadius)) {}

VolumePhotonMap::VolumePhotonMap(const Volume& volume, const Selection& selection)
    : volume_(volume),
      // A density over the sphere whose largest value is its mean is constant.
      isIsotropic_(volume.phasePeak() <= kInv4Pi * (1 + 1e-6f)),
      tree_(std::span<const Vec3>(selection.points)),
      rows_(inOrder(std::span<const Row>(selection.rows), tree_.order())) {
  tree_.dropOrder();
}

}  // namespace brume
