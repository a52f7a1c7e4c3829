// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/bsdf.h"
#include "core/interaction.h"
#include "core/light.h"

namespace brume {

/// A direction in which a light path goes on from a surface: by the BSDF, or, where `ball` is small
/// as seen from there, sometimes evenly in the cone around it. f is as in Bsdf::sample; pdf is that
/// of the mixture, so f cos / pdf is at most 1 / (1 - kAimedShare) of what the BSDF alone gives
/// (balance heuristic with one sample: Veach 1997, 9.2.4). A ball of radius 0 is not aimed at.
std::optional<BsdfSample> sampleTowards(const Bsdf& bsdf, const SurfaceInteraction& at,
                                        const Ball& ball, float uLobe, Vec2 u);

inline constexpr float kAimedShare = 0.25f;

}  // namespace brume
