// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/error.h"
#include "transport/photon_tracer.h"

namespace brume {
namespace {

/// The pilot's pass: no pass of a render has this number.
constexpr std::uint64_t kPilotPass = ~std::uint64_t{0};
constexpr std::uint64_t kFirstPilot = 1 << 14, kLastPilot = 1 << 18;
/// Photons of a class that the pilot wants to see: its yield is then known to about 5 %.
constexpr std::uint64_t kPilotPhotons = 400;
constexpr double kMaxPaths = 0x1p31;
/// Of optional classes, paths per photon asked for; but so many that few photons can be had.
constexpr double kMostPathsPerPhoton = 64, kAlwaysPaths = 0x1p20;

using Yield = std::array<std::uint64_t, kPhotonClasses>;

Yield countClasses(const std::vector<Photon>& photons) {
  Yield yield{};
  for (const Photon& photon : photons) ++yield[static_cast<std::size_t>(photon.photonClass())];
  return yield;
}

}  // namespace

PathsPerClass pathsFor(const PhotonTracer& tracer, const PhotonCounts& wanted,
                       PhotonClasses optional, std::uint64_t seed, const std::atomic<bool>& stop,
                       Stats& stats) {
  PathsPerClass paths{};
  if (wanted == PhotonCounts{}) return paths;
  if (!tracer.hasLights())
    throw SceneError("no photons can be stored: the scene has no light that emits");

  // Pilot passes, each four times as large, until every class has shown enough photons.
  Yield yield{};
  std::uint64_t pilot = kFirstPilot;
  for (;; pilot *= 4) {
    PathsPerClass all{};
    for (std::size_t c = 0; c < kPhotonClasses; ++c) all[c] = wanted[c] > 0 ? pilot : 0;
    yield = countClasses(tracer.trace(seed, kPilotPass, all, stop, stats).photons);
    if (stop.load(std::memory_order_relaxed)) return {};
    bool isEnough = true;
    for (std::size_t c = 0; c < kPhotonClasses; ++c)
      isEnough = isEnough && (wanted[c] == 0 || yield[c] >= kPilotPhotons);
    if (isEnough || pilot >= kLastPilot) break;
  }

  for (std::size_t c = 0; c < kPhotonClasses; ++c) {
    if (wanted[c] == 0) continue;
    const double needed = static_cast<double>(wanted[c]) * static_cast<double>(pilot) /
                          static_cast<double>(std::max<std::uint64_t>(1, yield[c]));
    const bool isOptional = optional.contains(static_cast<PhotonClass>(c));
    const double most =
        isOptional ? std::max(kAlwaysPaths, kMostPathsPerPhoton * static_cast<double>(wanted[c]))
                   : kMaxPaths;
    if (yield[c] > 0 && (isOptional || needed <= most)) {
      const double some = std::min({needed, most, kMaxPaths});
      paths[c] = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::llround(some)));
    } else if (!isOptional) {
      throw SceneError(
          yield[c] == 0
              ? fmt::format("no photon {} could be stored: of {} light paths none left one; the "
                            "lights do not reach there",
                            describe(static_cast<PhotonClass>(c)), pilot)
              : fmt::format("{} photons {} would take {:.3g} light paths: {} of {} left one; ask "
                            "for fewer, or light the scene from nearer",
                            wanted[c], describe(static_cast<PhotonClass>(c)), needed, yield[c],
                            pilot));
    }
  }
  return paths;
}

}  // namespace brume
