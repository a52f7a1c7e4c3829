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
};

/// A pass to come.
struct PassCost {
  double paths = 0;     ///< light paths
  double segments = 0;  ///< of light paths, all together; 0: its photons are there already
};

/// Radii in balance of noise and blur for passes like `pass`.
///
/// The pilot's photons are cut into two halves A and B, the light of different paths, and both are
/// looked up through a coarse grid of pixels with a ladder of radii r_k. Per pixel, relative to its
/// brightness,
///   variance of a half      V_k = <(A_k - B_k)^2> / 2
///   squared blur            b_k^2 = <(A_k - A_s)(B_k - B_s)> / (1 - r_s^2/r_k^2)^2
/// where s is two steps down; the halves are independent, so that noise drops out of the mean of
/// the product. With V = v / r^2 and b = c r^2 the schedule's error after n passes (alpha = 2/3) is
///   n^(-2/3) (3/4 v' / r^2 + 9/4 c^2 r^4),   v' = v times the paths of a half / those of a pass,
/// least at r^6 = v' / 6 c^2. c is taken from the smallest radius whose blur stands out of its
/// noise; where none does, from the bound that the noise leaves. At most a tenth of the media's
/// diagonal, and no more photons per beam and pass than cost as much as tracing, or
/// kAlwaysPerBeam. Where nothing is seen or no photons are there: a hundredth of the scene's
/// diagonal. Test: first_radius_test.
FirstRadii firstRadii(const Scene& scene, const CameraPaths& paths, const PassContext& context,
                      const PhotonSet& pilot, const PassCost& pass);

inline constexpr double kAlwaysPerBeam = 100;

}  // namespace brume
