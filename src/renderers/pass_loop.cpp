// SPDX-License-Identifier: Apache-2.0
#include "renderers/pass_loop.h"

#include <chrono>
#include <cmath>
#include <limits>

namespace brume {
namespace {

/// Samples per pixel of one portion: an interrupted render has a whole image after each.
constexpr std::int64_t kPortion = 16;
/// The estimated error is not believed before this many samples per pixel.
constexpr std::int64_t kMinSamplesForError = 16;
/// Sample indices stay within int.
constexpr std::int64_t kMaxSamples = std::int64_t{1} << 30;

class PortionLoop {
 public:
  PortionLoop(ImageRenderer& renderer, const Film& film, const RenderLimits& limits,
              const RenderWatch& watch)
      : renderer_(renderer), film_(film), limits_(limits), watch_(watch) {
    const std::int64_t most = std::max<std::int64_t>(1, kMaxSamples / limits.round);
    total_ = limits.round * std::min(most, limits.rounds.value_or(most));
  }

  RenderOutcome run(const std::atomic<bool>& stop, Stats& stats);

 private:
  bool renderPortion(std::int64_t portion, const std::atomic<bool>& stop, Stats& stats);
  using Clock = std::chrono::steady_clock;
  double seconds() const {
    return limits_.secondsSpent + std::chrono::duration<double>(Clock::now() - start_).count();
  }
  std::int64_t nextPortion() const;
  void showSnapshot();
  void estimateError();
  std::optional<StopReason> limitReached() const;
  RenderProgress progressAt(double share, std::int64_t portion, const Stats& stats) const;

  ImageRenderer& renderer_;
  const Film& film_;
  const RenderLimits& limits_;
  const RenderWatch& watch_;
  std::int64_t total_ = 0;
  RenderOutcome outcome_;
  std::int64_t lastPortion_ = 0;
  std::int64_t nextSnapshot_ = 1;  // [samples]
  double nextReport_ = kSecondsBetweenReports;
  Clock::time_point start_ = Clock::now();  // moved on by the time that snapshots take
};

std::int64_t PortionLoop::nextPortion() const {
  const std::int64_t left = total_ - outcome_.samples;
  if (limits_.wholeRounds) return std::min(limits_.round, left);
  std::int64_t portion = kPortion;
  if (limits_.maxSeconds || limits_.targetError)
    portion = std::max<std::int64_t>(1, 2 * lastPortion_);
  if (watch_.snapshot) portion = std::max<std::int64_t>(1, nextSnapshot_ - outcome_.samples);
  const auto atMost = [&](double samples) {
    if (samples < static_cast<double>(portion))
      portion = std::max<std::int64_t>(1, static_cast<std::int64_t>(samples));
  };
  // Half of the time that is left, so that an estimate which was too good does no harm; as many
  // samples as the error needs when its square falls as 1/n.
  const auto done = static_cast<double>(outcome_.samples);
  if (limits_.maxSeconds && done > 0)
    atMost(0.5 * (*limits_.maxSeconds - seconds()) * done /
           (outcome_.seconds - limits_.secondsSpent));
  if (limits_.targetError && outcome_.estimatedError)
    atMost(1 + done * (sqr(*outcome_.estimatedError / *limits_.targetError) - 1));
  return std::min(portion, left);
}

void PortionLoop::estimateError() {
  if (film_.settings().withVariance && outcome_.samples >= std::min(kMinSamplesForError, total_))
    outcome_.estimatedError =
        std::sqrt(sqr(film_.estimatedRelativeError()) + renderer_.squaredBlur());
}

std::optional<StopReason> PortionLoop::limitReached() const {
  if (limits_.targetError && outcome_.estimatedError &&
      *outcome_.estimatedError <= *limits_.targetError)
    return StopReason::Error;
  if (outcome_.samples >= total_) return StopReason::Done;
  if (limits_.maxSeconds && outcome_.seconds >= *limits_.maxSeconds) return StopReason::Time;
  return std::nullopt;
}

RenderProgress PortionLoop::progressAt(double share, std::int64_t portion,
                                       const Stats& stats) const {
  RenderProgress p;
  const double samples =
      static_cast<double>(outcome_.samples) + share * static_cast<double>(portion);
  p.seconds = seconds();
  p.pass = static_cast<int>(outcome_.samples / limits_.round) + 1;
  p.rays = stats[Stat::IntersectionRays] + stats[Stat::ShadowRays];
  p.photons = stats[Stat::PhotonsStored];
  p.estimatedError = outcome_.estimatedError;
  // Without a number of rounds the other limits alone tell how far it is.
  p.fraction = limits_.rounds ? samples / static_cast<double>(total_) : 0;
  if (limits_.maxSeconds) p.fraction = std::max(p.fraction, p.seconds / *limits_.maxSeconds);
  if (limits_.targetError && outcome_.estimatedError)
    p.fraction = std::max(p.fraction, sqr(*limits_.targetError / *outcome_.estimatedError));
  p.fraction = std::min(p.fraction, 1.0);
  return p;
}

void PortionLoop::showSnapshot() {
  if (!watch_.snapshot || outcome_.samples < nextSnapshot_) return;
  const Clock::time_point begin = Clock::now();
  watch_.snapshot(outcome_);
  start_ += Clock::now() - begin;
  const double next = std::ceil(kSnapshotGrowth * static_cast<double>(outcome_.samples));
  nextSnapshot_ = std::max(outcome_.samples + 1, static_cast<std::int64_t>(next));
}

bool PortionLoop::renderPortion(std::int64_t portion, const std::atomic<bool>& stop, Stats& stats) {
  const auto onShare = [&](double share, const Stats& soFar) {
    if (!watch_.progress || seconds() < nextReport_) return;
    watch_.progress(progressAt(share, portion, soFar));
    nextReport_ = seconds() + kSecondsBetweenReports;
  };
  try {
    return renderer_.render({outcome_.samples, outcome_.samples + portion}, stop, stats, onShare);
  } catch (...) {
    outcome_.seconds = seconds();
    if (watch_.rescue && outcome_.samples > 0) watch_.rescue(outcome_);
    throw;
  }
}

RenderOutcome PortionLoop::run(const std::atomic<bool>& stop, Stats& stats) {
  for (;;) {
    const std::int64_t portion = nextPortion();
    const bool isWhole = renderPortion(portion, stop, stats);
    outcome_.seconds = seconds();
    if (!isWhole) {
      outcome_.reason = StopReason::Interrupted;
      return outcome_;
    }
    outcome_.samples += portion;
    lastPortion_ = portion;
    estimateError();
    showSnapshot();
    if (const auto reason = limitReached()) {
      outcome_.reason = *reason;
      return outcome_;
    }
  }
}

}  // namespace

RenderOutcome renderPortions(ImageRenderer& renderer, const Film& film, const RenderLimits& limits,
                             const std::atomic<bool>& stop, Stats& stats,
                             const RenderWatch& watch) {
  return PortionLoop(renderer, film, limits, watch).run(stop, stats);
}

}  // namespace brume
