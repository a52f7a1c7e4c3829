// SPDX-License-Identifier: Apache-2.0
// Beams as cameras and mirrors make them, and photons where lookups go wrong.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "accelerators/beam_lookup.h"
#include "core/rng.h"

namespace brume::test {

/// Photons that own their coordinates.
struct PhotonCloud {
  std::vector<float> x, y, z;
  void add(const Vec3& p) {
    x.push_back(p.x);
    y.push_back(p.y);
    z.push_back(p.z);
  }
  std::size_t size() const { return x.size(); }
  Vec3 operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
  operator PhotonPositions() const { return PhotonPositions(x, y, z); }
};

enum class Rays { Pinhole, ThinLens, Orthographic, Environment, Mirrored, Scattered };
inline constexpr Rays kAllRays[] = {Rays::Pinhole,     Rays::ThinLens, Rays::Orthographic,
                                    Rays::Environment, Rays::Mirrored, Rays::Scattered};
std::string toString(Rays rays);

struct BeamScene {
  Rays rays = Rays::Pinhole;
  Vec2i resolution{64, 64};
  float t0 = 1, t1 = 5;   ///< along the rays; about, if uneven
  float radius = 0.05f;   ///< about, if uneven
  bool isUneven = false;  ///< ranges and radii differ from beam to beam, some are empty
  float share = 1;        ///< of the pixels that have a beam
  int beamsPerPixel = 1;
  Vec3 shift{0};  ///< of everything
};

/// In random order of the pixels, as the caller of a lookup may have them.
std::vector<Beam> makeBeams(const BeamScene& scene, std::uint64_t seed);

/// Photons in the box of the beams, inside beams, within an ulp of their ends and radii, at and
/// behind their origins, and very far away.
PhotonCloud awkwardPhotons(const std::vector<Beam>& beams, int count, std::uint64_t seed);

}  // namespace brume::test
