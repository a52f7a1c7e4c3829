// SPDX-License-Identifier: Apache-2.0
// How many light paths the photons of a map take, and how many there is time for.
#pragma once

#include <atomic>
#include <chrono>
#include <cmath>

#include "core/integrator.h"
#include "transport/photon_tracer.h"

namespace brume {

/// How many photons of each class to store; 0: none of it.
using PhotonCounts = std::array<std::uint64_t, kPhotonClasses>;

/// Paths that store about the wanted numbers. Found by a pilot pass of its own random numbers, so
/// that the photons themselves stay unbiased: the number of paths does not depend on them. Throws
/// SceneError, with the reason, when a class that is wanted stores nothing or would take more than
/// 2^31 paths. Classes in `optional` get 0 paths when they store nothing, and no more than 64 paths
/// per photon (2^20 at least) where few leave one: fewer photons then carry that light. The pilot
/// does not grow beyond `mostSeconds`.
PathsPerClass pathsFor(const PhotonTracer& tracer, const PhotonCounts& wanted,
                       PhotonClasses optional, std::uint64_t seed, const std::atomic<bool>& stop,
                       Stats& stats, double mostSeconds = HUGE_VAL);

/// Traces the photons of a map within the time that there is for it, its tree included.
class PhotonMapTracing {
 public:
  /// The clock starts here: pilots count.
  explicit PhotonMapTracing(const PrepareContext& context);
  double secondsForPilots() const;
  /// Pass 0. Fewer paths than asked for, and a warning, where all would take longer than the pilots
  /// leave time for (PrepareContext::secondsForPhotons).
  PhotonSet trace(const PhotonTracer& tracer, PathsPerClass paths) const;

 private:
  double seconds() const;
  void limitToTime(PathsPerClass& paths) const;

  const PrepareContext& context_;
  std::uint64_t pathsBefore_, photonsBefore_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace brume
