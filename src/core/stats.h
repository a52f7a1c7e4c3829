// SPDX-License-Identifier: Apache-2.0
// Counters of what a render did. Each thread of a pass has its own Stats; they are merged when the
// pass ends.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "core/rgb.h"

namespace brume {

/// "Group/name" is what the table and the JSON show (statName).
enum class Stat {
  CameraRays,
  IntersectionRays,
  ShadowRays,
  CameraPaths,
  PathSegments,
  SurfaceHits,
  VolumeSegments,
  VolumeSamples,
  RussianRouletteStops,
  PhotonPaths,
  PhotonSegments,
  PhotonsStored,
  PhotonBeamPairs,
  NanRadiance,
  InfiniteRadiance,
  NegativeRadiance,
  Count
};
std::string_view statName(Stat stat);

class Stats {
 public:
  void add(Stat stat, std::uint64_t n = 1) { values_[static_cast<std::size_t>(stat)] += n; }
  std::uint64_t operator[](Stat stat) const { return values_[static_cast<std::size_t>(stat)]; }
  void merge(const Stats& o) {
    for (std::size_t i = 0; i < values_.size(); ++i) values_[i] += o.values_[i];
  }
  /// Counts a radiance that is NaN, infinite or negative where it was born and returns what the
  /// film may take: the value itself, or black when it is not finite.
  Rgb checkRadiance(const Rgb& L);

 private:
  std::array<std::uint64_t, static_cast<std::size_t>(Stat::Count)> values_{};
};

}  // namespace brume
