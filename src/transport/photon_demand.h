// SPDX-License-Identifier: Apache-2.0
// Which photons make the noise of an image.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/integrator.h"
#include "transport/photon.h"

namespace brume {

/// Places where the camera rays of a coarse grid of pixels, or what follows them through mirrors
/// and glass, look for photons: on surfaces, and one in each stretch of media, drawn by the share
/// of the light that is scattered there. Looked up among the k nearest photons of a pilot, the
/// relative variance at x_j is
///   sum_{i < k} P_i^2 / (sum_{i < k} P_i)^2,   P the largest channel of a photon's power,
/// so that a photon anywhere does
///   c^2 = P^2 sum_{j: |x - x_j| < r_j} w_j^2 / (sum P)_j^2
/// to the noise of the image, r_j the reach of the k nearest, w_j how much of the light at x_j the
/// pixel gets. Deterministic. Test: photon_demand_test.
class PhotonDemand {
 public:
  PhotonDemand(const Scene& scene, const ImageView& view, std::span<const Photon> pilot,
               std::uint64_t seed, Stats& stats);

  /// Nothing is looked up, or nothing found.
  bool isEmpty() const { return places_[0].empty() && places_[1].empty(); }
  /// The sum of c^2 over some photons.
  double squareOf(std::span<const Photon> photons) const;

 private:
  struct Place {
    Vec3 p;                 ///< render space
    float radius2, weight;  ///< r_j^2, w_j^2 / (sum P)_j^2
  };
  static std::size_t kindOf(const Photon& photon) { return photon.isOnSurface() ? 1 : 0; }

  std::array<std::vector<Place>, 2> places_;  // in media, on surfaces
};

}  // namespace brume
