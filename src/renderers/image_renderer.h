// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

#include "core/stats.h"

namespace brume {

/// A range of samples of every pixel, in units of an average pixel: [first, end) of
/// rounds * samplesPerPixel.
struct SampleRange {
  std::int64_t first = 0, end = 0;
  std::int64_t count() const { return end - first; }
};

/// Adds samples to a film, portion by portion.
class ImageRenderer {
 public:
  virtual ~ImageRenderer() = default;
  /// Adds the samples to the film. A set `stop` ends the work early; what the film got stays valid.
  /// `onShare` is called now and then with the share of the range that is done and the statistics
  /// so far (stats included), from one thread at a time. Returns whether the whole range was
  /// rendered.
  virtual bool render(SampleRange range, const std::atomic<bool>& stop, Stats& stats,
                      const std::function<void(double share, const Stats& stats)>& onShare) = 0;
  /// The part of the image's squared relative error that its variance does not show.
  virtual double squaredBlur() const { return 0; }
};

}  // namespace brume
