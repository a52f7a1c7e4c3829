// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/accelerator.h"
#include "core/interaction.h"

namespace brume {

/// The part of a photon kernel's disc that lies on the surface around a point, weighted by the
/// kernel:
///   share = 1/n sum_j F(rho_j),   F(rho) = Int_{d < rho} K2 dA = 1 - (1 - rho^2 / r^2)^3
/// rho_j how far the surface goes on in the j-th direction of the tangent plane: until something
/// stands on it (a ray in the height `slab` above it), or it falls away by `slab` (a ray back, as
/// far below). An estimate over that share does not darken towards walls and edges. A sheet that
/// just ends is taken to go on. At least kLeastShare.
float surfaceShare(const Accelerator& accelerator, const SurfaceInteraction& at, float radius,
                   float slab);

/// Whether something stands between the point and another one on its surface, `slab` above both.
bool isBehindAnEdge(const Accelerator& accelerator, const SurfaceInteraction& at, const Vec3& p,
                    float slab);

/// A number in [0, 1) for a point, other than those that surfaceShare uses.
float chanceOf(const Vec3& p);

inline constexpr float kLeastShare = 0.05f;

}  // namespace brume
