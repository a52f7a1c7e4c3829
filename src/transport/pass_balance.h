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
/// measured, so that images repeat: in path segments, a camera path is 12, and a photon in a medium
/// or on a surface, with the search of its beams or points, 5. That is about what the shares of a
/// pass say (bench/pass_shares.py): camera paths 3 to 16 segments, of which more is taken because
/// photons make most of the noise, and photons 3 to 6, 36 in a fine grid. At most two million
/// photons are left in a pass, some 200 MB. Test: pass_balance_test.
std::int64_t balancedPaths(std::int64_t cameraPaths, const LightPathMean& mean);

}  // namespace brume
