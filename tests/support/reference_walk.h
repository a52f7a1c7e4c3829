// SPDX-License-Identifier: Apache-2.0
// Multiple scattering by the plainest of methods, in double, with nothing of brume's: delta
// tracking, textbook Henyey-Greenstein, ratio tracking towards one point light that lies outside
// of all media. Slow and sure: the judge of the judge in scenes without surfaces.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "support/estimate.h"

namespace brume::test {

using Point = std::array<double, 3>;

/// A box of medium with its own phase function.
struct ReferenceMedium {
  Point lo, hi;
  std::array<double, 3> sigma_a, sigma_s;  ///< at density 1
  double g = 0;
  double maxDensity = 1;
  std::function<double(const Point&)> density = [](const Point&) { return 1.0; };
};

struct ReferenceScene {
  std::vector<ReferenceMedium> media;
  Point light;
  std::array<double, 3> I;
  Point camera, target;
};

/// Radiance that reaches the camera from the target's direction in one channel.
Estimate referenceRadiance(const ReferenceScene& scene, std::size_t channel, std::int64_t paths,
                           std::uint64_t seed);

}  // namespace brume::test
