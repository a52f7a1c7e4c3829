// SPDX-License-Identifier: Apache-2.0
// Volume photons looked up by beams: the physics of the beam radiance estimate.
#pragma once

#include <span>
#include <vector>

#include "accelerators/beam_lookup.h"
#include "core/scene.h"
#include "transport/beam_gather.h"
#include "transport/camera_beams.h"
#include "transport/photon.h"

namespace brume {

inline constexpr Bounds3 kEverywhere{Vec3(-kInfinity), Vec3(kInfinity)};
/// All points that the beams may contain, rounding included.
Bounds3 reachOf(std::span<const Beam> beams);

struct VolumePhotonOptions {
  /// Photons outside are left out: none of the beams can receive them (reachOf).
  Bounds3 reach = kEverywhere;
  float mirrorRadius = 0;  ///< of the beams, for PhotonMirror; 0: no mirror images
};

/// The photons of a pass as beams need them, in an order in which neighbours are near each other.
class VolumePhotons {
 public:
  VolumePhotons() = default;
  VolumePhotons(const Volume& volume, std::span<const Photon> photons,
                const VolumePhotonOptions& options = {}) {
    assign(volume, photons, options);
  }
  /// Takes the volume photons among the given ones instead of those it has; memory is used again.
  void assign(const Volume& volume, std::span<const Photon> photons,
              const VolumePhotonOptions& options = {});

  std::span<const BeamPhoton> all() const { return photons_; }
  /// What BeamPhoton::lobesBegin counts in.
  std::span<const BeamLobe> moreLobes() const { return lobes_; }
  /// The phase functions are sums of lobes: those of the photons.
  bool haveLobes() const { return haveLobes_; }
  /// How many volume photons were left out.
  std::size_t outsideCount() const { return outside_; }
  PhotonPositions positions() const { return {all(), &BeamPhoton::p}; }

 private:
  /// A photon's place along a space-filling curve.
  struct Place {
    std::uint32_t code;
    std::uint32_t photon;  // or, from their number on, mirror image
  };
  struct MirrorImage {
    std::uint32_t photon;
    Vec3 p;
    Rgb share;  // of the photon's power
  };
  struct Placed;
  struct Part;

  std::vector<Placed> placesOf(const Volume& volume, std::span<const Photon> photons,
                               const VolumePhotonOptions& options) const;
  void sort(std::span<const Placed> parts, std::size_t photonCount);
  void fill(const Volume& volume, std::span<const Photon> photons);

  std::vector<BeamPhoton> photons_;
  std::vector<BeamLobe> lobes_;
  bool haveLobes_ = true;
  std::size_t outside_ = 0;
  // Kept for their memory.
  std::vector<Place> order_, other_;
  std::vector<MirrorImage> images_;
};

/// The beam radiance estimate of every beam:
///   sum_{i: d_i < r} Tr(t0, t_i) albedo(x_i) f_p(w_i, w) alpha_i K2(d_i; r)     [W m^-2 sr^-1]
/// A quadtree takes gatherHomogeneous or gatherInMedia, eight beams at a time; other lookups, and
/// phase functions without lobes, go pair by pair. The memory of `old` is used again.
std::vector<BeamSum> gatherBeams(const Volume& volume, const OwnedBeams& beams,
                                 const BeamLookup& lookup, const VolumePhotons& photons,
                                 std::vector<BeamSum> old = {});

}  // namespace brume
