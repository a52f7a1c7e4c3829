// SPDX-License-Identifier: Apache-2.0
// Lights from all around that rays find by themselves.
#pragma once

#include <vector>

#include "core/plan.h"
#include "core/scene.h"

namespace brume {

/// How much less even than a constant sky an infinite light is: the second moment of what a ray in
/// a random direction brings over the square of its mean,
///   V = 4 pi Int L^2 dw / (Int L dw)^2,   L the luminance; 1 when it is constant, at least 1
/// To some per cent, from a thousand directions that the light samples. Infinite for a black one.
double unevenness(const Light& sky);

/// The lights of emittingLights that a path must look at: all but skies of V up to 2, half of the
/// sphere bright. There a direction drawn by a phase function or BSDF is as good as one drawn by
/// the light, and the path has that one in any case (measured: docs/theory.md). Test:
/// even_sky_test.
std::vector<const Light*> lightsToLookAt(const Scene& scene);
/// What the plan says where a sky is left out.
void planEvenSky(Plan& plan);

}  // namespace brume
