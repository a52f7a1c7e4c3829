// SPDX-License-Identifier: Apache-2.0
// How many samples are taken, in which portions, and when it is enough.
#pragma once

#include <atomic>
#include <functional>

#include "core/film.h"
#include "renderers/image_renderer.h"
#include "renderers/render_job.h"

namespace brume {

/// When to stop; the first limit that is reached counts.
struct RenderLimits {
  std::int64_t round = 1;              ///< samples per pixel and round
  bool wholeRounds = false;            ///< the sampler cannot split a round
  std::optional<std::int64_t> rounds;  ///< none: only the other limits
  std::optional<double> maxSeconds;    ///< exceeded by less than one portion
  std::optional<double> targetError;   ///< noise (Film::estimatedRelativeError) and blur
  double secondsSpent = 0;             ///< before the first portion (photon maps); they count
};

struct RenderOutcome {
  StopReason reason = StopReason::Done;
  std::int64_t samples = 0;  ///< per average pixel, of finished portions
  double seconds = 0;
  std::optional<double> estimatedError;
};

inline constexpr double kSecondsBetweenReports = 0.25;

/// Who is told how far the render is; each may be empty. Called from one thread at a time.
struct RenderWatch {
  std::function<void(const RenderProgress&)> progress;  ///< a few times a second at most
  /// After the first portion, and whenever the samples have grown by kSnapshotGrowth since; what it
  /// takes is not counted in any time.
  std::function<void(const RenderOutcome&)> snapshot;
  /// When a portion fails, with what was finished before it; then the failure is thrown.
  std::function<void(const RenderOutcome&)> rescue = {};
};

/// Renders portion after portion until a limit is reached or `stop` is set. Without time and error
/// limits the portions are of fixed size, or fixed by the snapshots, so that the image depends on
/// the rounds alone.
RenderOutcome renderPortions(ImageRenderer& renderer, const Film& film, const RenderLimits& limits,
                             const std::atomic<bool>& stop, Stats& stats, const RenderWatch& watch);

}  // namespace brume
