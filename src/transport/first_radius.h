// SPDX-License-Identifier: Apache-2.0
// Radii to begin with, from the density of photons.
#pragma once

#include <span>

#include "core/scene.h"
#include "transport/photon.h"

namespace brume {

/// Photons that a beam, and a visible point, is to meet in the first pass.
inline constexpr double kPhotonsPerBeam = 50, kPhotonsPerPoint = 10;

/// r with Pi r^2 L n = kPhotonsPerBeam: n the median density of volume photons [length^-3], times
/// `perPhoton`, the photons of a pass for each one given; L the mean chord of the media's bounds,
/// 4 V / S. Never more than a tenth of the bounds' diagonal, which it is without photons.
double firstBeamRadius(std::span<const Photon> photons, const Volume& volume, double perPhoton);

/// The same on surfaces: Pi r^2 n = kPhotonsPerPoint, n the median density of surface photons
/// [length^-2].
double firstSurfaceRadius(std::span<const Photon> photons, const Scene& scene, double perPhoton);

}  // namespace brume
