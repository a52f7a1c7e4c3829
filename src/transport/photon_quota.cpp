// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_quota.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/log.h"

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

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Of the time for photons, that their pilots may take.
constexpr double kPilotShare = 0.3;
/// However little time there is.
constexpr double kFewestPaths = 1000;
/// What trees and radii take for each photon [s], on one thread (bench/photon_tracing).
constexpr double kSecondsPerStored = 3e-6;

}  // namespace

PathsPerClass pathsFor(const PhotonTracer& tracer, const PhotonCounts& wanted,
                       PhotonClasses optional, std::uint64_t seed, const std::atomic<bool>& stop,
                       Stats& stats, double mostSeconds) {
  PathsPerClass paths{};
  if (wanted == PhotonCounts{}) return paths;
  if (!tracer.hasLights())
    throw SceneError("no photons can be stored: the scene has no light that emits");

  // Pilot passes, each four times as large, until every class has shown enough photons.
  Yield yield{};
  std::uint64_t pilot = kFirstPilot;
  const auto start = std::chrono::steady_clock::now();
  for (;; pilot *= 4) {
    PathsPerClass all{};
    for (std::size_t c = 0; c < kPhotonClasses; ++c) all[c] = wanted[c] > 0 ? pilot : 0;
    yield = countClasses(tracer.trace(seed, kPilotPass, all, stop, stats).photons);
    if (stop.load(std::memory_order_relaxed)) return {};
    bool isEnough = true;
    for (std::size_t c = 0; c < kPhotonClasses; ++c)
      isEnough = isEnough && (wanted[c] == 0 || yield[c] >= kPilotPhotons);
    // The next one takes three times as long as all so far.
    const bool isLate = 4 * secondsSince(start) > mostSeconds;
    if (isEnough || isLate || pilot >= kLastPilot) break;
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

PhotonMapTracing::PhotonMapTracing(const PrepareContext& context)
    : context_(context),
      pathsBefore_(context.stats[Stat::PhotonPaths]),
      photonsBefore_(context.stats[Stat::PhotonsStored]) {}

double PhotonMapTracing::seconds() const { return secondsSince(start_); }

double PhotonMapTracing::secondsForPilots() const {
  return kPilotShare * context_.secondsForPhotons - seconds();
}

void PhotonMapTracing::limitToTime(PathsPerClass& paths) const {
  const auto piloted = static_cast<double>(context_.stats[Stat::PhotonPaths] - pathsBefore_),
             stored = static_cast<double>(context_.stats[Stat::PhotonsStored] - photonsBefore_);
  const std::uint64_t most = *std::max_element(paths.begin(), paths.end());
  const double spent = seconds(), left = context_.secondsForPhotons - spent;
  const double room = std::max(kFewestPaths, left * piloted / (spent + kSecondsPerStored * stored));
  if (!(piloted > 0) || static_cast<double>(most) <= room) return;
  const auto fitting = static_cast<std::uint64_t>(room);
  context_.log.warning({}, fmt::format("--time leaves room for {} light paths; the photons that "
                                       "were asked for take {}",
                                       fitting, most));
  for (std::uint64_t& n : paths) n = std::min(n, fitting);
}

PhotonSet PhotonMapTracing::trace(const PhotonTracer& tracer, PathsPerClass paths) const {
  if (std::isfinite(context_.secondsForPhotons)) limitToTime(paths);
  const auto onShare = [this](double share) { context_.onShare("tracing photons", share); };
  return tracer.trace(context_.seed, 0, paths, context_.stop, context_.stats, {},
                      context_.onShare ? std::function<void(double)>(onShare) : nullptr);
}

}  // namespace brume
