// SPDX-License-Identifier: Apache-2.0
#include "transport/pass_balance.h"

#include <algorithm>

namespace brume {

std::int64_t balancedPaths(std::int64_t cameraPaths, const LightPathMean& mean) {
  constexpr double kCameraPath = 12, kPhoton = 5;  // segments
  constexpr double kMostPhotons = 2 << 20;
  constexpr double kFewest = 1000, kMost = 1 << 30;
  // A path has one segment at least.
  const double cost = std::max(1.0, mean.segments) + kPhoton * mean.photons;
  double paths = kCameraPath * static_cast<double>(cameraPaths) / cost;
  if (mean.photons > 0) paths = std::min(paths, kMostPhotons / mean.photons);
  return static_cast<std::int64_t>(std::clamp(paths, kFewest, kMost));
}

}  // namespace brume
