// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "accelerators/photon_kdtree.h"
#include "core/bsdf.h"
#include "core/interaction.h"
#include "transport/photon.h"

namespace brume {

class Accelerator;

/// Photons on surfaces, and the radiance that they give to a point:
///   L(o, wo) ~= sum_{d_i < r} f(wo, wi) |wi.ns| / |wi.n_i| alpha_i K2(d_i; r)   [W m^-2 sr^-1]
/// f BSDF without specular lobes [1/sr], alpha_i photon power [W], K2 kernel [length^-2]. The
/// cosines turn the photons' irradiance, which counts by the geometric normal n_i where each of
/// them lies, into that of the shading normal. Photons on surfaces that lean away (normals more
/// than 60 degrees apart) or lie off the tangent plane by more than a quarter of the radius are
/// left out: light does not leak around corners; where some are, the estimate is divided by the
/// part of the disc that lies on the surface (surfaceShare), and photons behind what stands on it
/// are left out. Bias O(r^2). Immutable and thread-safe. Test: surface_photon_map_test.
class SurfacePhotonMap {
 public:
  /// Takes the surface photons among the given ones. Without an accelerator, estimates are too dark
  /// within r of edges.
  explicit SurfacePhotonMap(std::span<const Photon> photons,
                            const Accelerator* accelerator = nullptr);

  bool isEmpty() const { return tree_.size() == 0; }
  const PhotonKdTree& tree() const { return tree_; }
  /// In the order of the tree.
  std::span<const Photon> photons() const { return photons_; }

  /// All photons within a radius.
  Rgb radiance(const SurfaceInteraction& at, const Bsdf& bsdf, float radius) const;
  /// The k nearest within maxRadius; the radius is the distance to the k-th, which does not count
  /// itself: (k - 1) / (Pi r_k^2) is the unbiased density. Fewer than k: all, by maxRadius.
  Rgb radianceOfNearest(const SurfaceInteraction& at, const Bsdf& bsdf, std::size_t k,
                        float maxRadius) const;
  /// Irradiance on the side of wo by the k nearest [W m^-2].
  Rgb irradianceOfNearest(const SurfaceInteraction& at, std::size_t k, float maxRadius) const;

 private:
  SurfacePhotonMap(std::vector<Photon> photons, const Accelerator* accelerator);
  template <class LightOf>
  struct Disc;
  template <class LightOf>
  Rgb ofNearest(const SurfaceInteraction& at, std::size_t k, float maxRadius,
                const LightOf& lightOf) const;

  /// What lookups ask of a photon again and again.
  struct Directions {
    Vec3 wi, n;
  };

  PhotonKdTree tree_;
  std::vector<Photon> photons_;
  std::vector<Directions> directions_;  // of the photons, unpacked
  const Accelerator* accelerator_;
};

}  // namespace brume
