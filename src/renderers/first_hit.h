// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/film_layers.h"
#include "core/scene.h"

namespace brume {

/// Fills what the layers say of the first surface on a camera ray and of the media before it.
void describeFirstHit(const Scene& scene, const FootprintRay& ray, LayerSample& sample,
                      Stats& stats);

}  // namespace brume
