// SPDX-License-Identifier: Apache-2.0
// Radii to begin with, from what the camera sees of the photons.
#pragma once

#include <optional>
#include <span>

#include "core/integrator.h"
#include "transport/photon.h"

namespace brume {

/// Photons that a beam (each counted by the transmittance from the camera), and a visible point, is
/// to meet in the first pass.
inline constexpr double kPhotonsPerBeam = 50, kPhotonsPerPoint = 10;

struct FirstRadii {
  double beam = 0, surface = 0;  ///< scene length
};

/// Looks through a coarse grid of pixels. For each ray, the radius around it within which a pass
/// will leave kPhotonsPerBeam photons in the media, and the one around its hit for surfaces; of
/// all, the medians; beams at most a twentieth of the media's diagonal. `perPhoton`: the photons of
/// a pass for each one given. Where nothing is seen or no photons are there: a hundredth of the
/// scene's diagonal.
FirstRadii firstRadii(const Scene& scene, const PassContext& context,
                      std::span<const Photon> photons, double perPhoton);

}  // namespace brume
