// SPDX-License-Identifier: Apache-2.0
#include "core/stats.h"

namespace brume {

std::string_view statName(Stat stat) {
  switch (stat) {
    case Stat::CameraRays:
      return "Rays/camera";
    case Stat::IntersectionRays:
      return "Rays/intersection";
    case Stat::ShadowRays:
      return "Rays/shadow";
    case Stat::CameraPaths:
      return "Paths/camera";
    case Stat::PathSegments:
      return "Paths/segments";
    case Stat::SurfaceHits:
      return "Surfaces/hits";
    case Stat::VolumeSegments:
      return "Volumes/segments";
    case Stat::VolumeSamples:
      return "Volumes/samples";
    case Stat::RussianRouletteStops:
      return "Paths/roulette stops";
    case Stat::PhotonPaths:
      return "Photons/paths";
    case Stat::PhotonSegments:
      return "Photons/path segments";
    case Stat::PhotonsStored:
      return "Photons/stored";
    case Stat::PhotonBeamPairs:
      return "Photons/in beams";
    case Stat::NanRadiance:
      return "Faults/NaN radiance";
    case Stat::InfiniteRadiance:
      return "Faults/infinite radiance";
    case Stat::NegativeRadiance:
      return "Faults/negative radiance";
    case Stat::Count:
      break;
  }
  return "";
}

Rgb Stats::checkRadiance(const Rgb& L) {
  if (L.isFinite()) {
    if (L.minChannel() < 0) add(Stat::NegativeRadiance);
    return L;
  }
  const bool isNan = std::isnan(L.r) || std::isnan(L.g) || std::isnan(L.b);
  add(isNan ? Stat::NanRadiance : Stat::InfiniteRadiance);
  return {};
}

}  // namespace brume
