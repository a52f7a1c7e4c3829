// SPDX-License-Identifier: Apache-2.0
// The radii that a progressive render begins with, from a pilot pass.
#pragma once

#include <optional>

#include "core/integrator.h"
#include "transport/camera_path.h"
#include "transport/photon_tracer.h"

namespace brume {

struct FirstRadii {
  double beam = 0, surface = 0;  ///< scene length
  /// What the noise of a pass would be at these radii: the mean over pixels of its square, relative
  /// to the whole light of each; 0 where unknown.
  double beamVariance = 0, surfaceVariance = 0;
  /// Where a photon must be to be received: around the beams and the visible points of the probed
  /// pixels.
  Bounds3 beamReach, surfaceReach;
};

/// A pass to come.
struct PassCost {
  double paths = 0;     ///< light paths
  double segments = 0;  ///< of light paths, all together; 0: its photons are there already
};

/// Radii in balance of noise and blur.
///
/// The pilot's photons are cut into two halves A and B, the light of different paths, and both are
/// looked up through a coarse grid of pixels with a ladder of radii r_k. Per pixel, relative to its
/// brightness,
///   variance of a half      V_k = <(A_k - B_k)^2> / 2
///   squared blur            b_k^2 = <(A_k - A_s)(B_k - B_s)> / (1 - r_s^2/r_k^2)^2
/// where s is two steps down; the halves are independent, so that noise drops out of the mean of
/// the product. Blur is taken from the smallest radius at which it stands out of its noise; where
/// it does nowhere, from the bound that the noise leaves at the largest. From there V falls as r^-2
/// and b^2 as r^3, a compromise of smooth light (r^4) and edges (r^2 and less). Then, with n
/// passes,
///   n^(-2/3) (3/4 V + 16/9 b^2)        alpha = 2/3
/// is the squared error, and r the radius at which blur is kNoiseOverBlur times below noise: a bit
/// less than the best, so that the passes' variance tells the error (--error). That is the radius
/// of passes with kUsualPaths; of others it is (kUsualPaths / paths)^(1/6) times as large, so that
/// the radius after as many paths is the same whatever their number in a pass. Beams are at most a
/// tenth of the media's diagonal, with no more photons per beam and pass than cost as much as
/// tracing, or kAlwaysPerBeam. Where nothing is seen or no photons are there: a hundredth of the
/// scene's diagonal. Test: first_radius_test.
FirstRadii firstRadii(const Scene& scene, const CameraPaths& paths, const PassContext& context,
                      const PhotonSet& pilot, const PassCost& pass);

inline constexpr double kAlwaysPerBeam = 100, kNoiseOverBlur = 8, kUsualPaths = 200'000;

}  // namespace brume
