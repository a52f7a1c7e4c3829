// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace brume {

/// What one light path of a scene is, in the mean.
struct LightPathMean {
  double segments = 0;  ///< of the path
  double photons = 0;   ///< that it leaves
};

/// How many light paths a pass of pvpm should have for so many camera paths: as many as take about
/// as long. With C the time of the camera paths, c that of a light path, and V + W / n the variance
/// of a pass of n light paths, the time to an error goes as
///   (C + c n) (V + W / n)
/// of which n = C / c is at most twice the least, whatever V and W. Times are counted, not
/// measured, so that images repeat: in path segments, a camera path is 30 and the search of a
/// photon's beams or points 5.5, about what the six scenes of bench/photons.json take (camera paths
/// 1.6 to 5 us, a segment 0.1 us, a photon 0.3 to 1.3 us). At most two million photons are left in
/// a pass, some 200 MB. Test: pass_balance_test.
std::int64_t balancedPaths(std::int64_t cameraPaths, const LightPathMean& mean);

}  // namespace brume
