// SPDX-License-Identifier: Apache-2.0
// Mirror and glass: bounces whose direction is fixed by the BSDF, with the footprint carried along.
#pragma once

#include "core/bsdf.h"
#include "core/integrator.h"

namespace brume {

/// The ray after a specular bounce at a surface hit by `incoming`, with the neighbouring rays
/// reflected or refracted alike (Igehy 1999). No footprint when `incoming` has none.
FootprintRay specularRay(const FootprintRay& incoming, const SurfaceInteraction& at,
                         const Vec3& shadingNormal, const BsdfSample& sample);

/// Radiance that specular lobes carry to wo, followed while query.depth + 1 < maxDepth as in
/// PBRT-v2. The first bounces follow reflection and refraction both; deeper ones choose one of the
/// two and go on by roulette, so that the tree does not grow exponentially. Unbiased.
Rgb specularRadiance(const SurfaceQuery& query, const Bsdf& bsdf, int maxDepth,
                     RenderContext& context);

}  // namespace brume
