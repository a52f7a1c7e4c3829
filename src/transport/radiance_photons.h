// SPDX-License-Identifier: Apache-2.0
// Surface points whose reflected radiance is known beforehand, so that final gathering needs one
// search of one neighbour per ray.
#pragma once

#include "core/scene.h"
#include "transport/surface_photon_map.h"

namespace brume {

/// How the photons around a site are looked up.
struct RadianceLookup {
  std::size_t nearest = 50;       ///< so many of each map
  float maxDistance = kInfinity;  ///< and no farther than this
  float time = 0;                 ///< at which the surfaces are seen
};

/// Radiance photons stand where photons were stored, on the side that the light came to:
///   Lo = rho_r/Pi E(n) + rho_t/Pi E(-n)                                      [W m^-2 sr^-1]
/// E irradiance by the photons of all maps [W m^-2], rho hemispherical reflectance and
/// transmittance without specular lobes. The same in all directions: glossy surfaces look as if
/// they were diffuse. Photons on neighbouring surfaces count, as far as their light comes to the
/// side of n: in corners they make up for the part of the disc that lies beyond. Source:
/// Christensen 1999, Faster Photon Map Global Illumination; PBRT-v2. Immutable and thread-safe.
/// Test: radiance_photons_test.
class RadiancePhotons {
 public:
  /// `sites` are the photons at which they are to stand, none of those in the maps, which hold all
  /// light on surfaces.
  RadiancePhotons(const Scene& scene, std::span<const Photon> sites,
                  std::span<const SurfacePhotonMap* const> maps, const RadianceLookup& lookup,
                  Stats& stats);

  std::size_t size() const { return tree_.size(); }
  /// Radiance that leaves p on the side of the unit vector n: that of the nearest radiance photon
  /// whose normal is less than 84 degrees away, of the kSearched nearest ones; black without any.
  Rgb radiance(const Vec3& p, const Vec3& n) const;

 private:
  struct Site {
    Vec3 p{0}, n{0};
    Rgb Lo;
  };
  explicit RadiancePhotons(std::vector<Site> sites);
  static std::vector<Site> evaluate(const Scene& scene, std::span<const Photon> sites,
                                    std::span<const SurfacePhotonMap* const> maps,
                                    const RadianceLookup& lookup, Stats& stats);

  PhotonKdTree tree_;
  std::vector<Site> sites_;
};

}  // namespace brume
