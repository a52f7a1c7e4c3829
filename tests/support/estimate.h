// SPDX-License-Identifier: Apache-2.0
// The mean of an image with its standard error, for tests of noisy renders.
#pragma once

#include <cmath>
#include <string>

#include "core/io/image.h"

namespace brume {

struct Estimate {
  double mean = 0;
  double standardError = 0;
  /// Deviation from an exact value, in standard errors.
  double z(double expected) const { return (mean - expected) / standardError; }
  /// The same against another estimate.
  double z(const Estimate& o) const {
    return (mean - o.mean) / std::hypot(standardError, o.standardError);
  }
};

/// Mean over the pixels of one channel; the error from their scatter, so all pixels must see the
/// same and be independent (sampler "random").
inline Estimate estimateOf(const LayeredImage& image, const std::string& channel) {
  const auto& values = image.channels.at(channel);
  const double n = static_cast<double>(values.size());
  double sum = 0, squares = 0;
  for (float v : values) sum += static_cast<double>(v);
  const double mean = sum / n;
  for (float v : values)
    squares += (static_cast<double>(v) - mean) * (static_cast<double>(v) - mean);
  return {mean, std::sqrt(squares / (n * (n - 1)))};
}

}  // namespace brume
