// SPDX-License-Identifier: Apache-2.0
// What bounds the beams of a tree's node: a cone frustum, which grows with distance as neighbouring
// beams of a camera do.
#pragma once

#include <span>

#include "accelerators/beam_lookup.h"

namespace brume {

/// The points p with s0 <= s <= s1 and |p - a - s u| <= r0 + k s, where s = (p - a).u.
struct BeamFrustum {
  Vec3 a{0}, u{0, 0, 1};
  float s0 = kInfinity, s1 = -kInfinity;  ///< empty as it is made
  float r0 = 0, k = 0;

  bool isEmpty() const { return !(s0 <= s1); }
  /// Computed in float; true for every point that is inside one of the beams by isInBeam.
  bool mayContain(const Vec3& p) const {
    const auto foot = beamFoot(a, u, p);
    return foot.t >= s0 && foot.t <= s1 && foot.d2 <= sqr(r0 + k * foot.t);
  }
};

/// The smallest frustum found around beams (none of them empty) or around frusta (empty ones count
/// for nothing); wide enough that neither the rounding here nor that of mayContain and beamFoot
/// loses a point.
BeamFrustum boundBeams(std::span<const Beam> beams);
BeamFrustum boundFrusta(std::span<const BeamFrustum> frusta);

}  // namespace brume
