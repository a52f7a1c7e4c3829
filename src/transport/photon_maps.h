// SPDX-License-Identifier: Apache-2.0
// The photons of a render that needs no more than one set of them: numbers, tracing, maps.
#pragma once

#include "core/integrator.h"
#include "transport/photon_tracer.h"
#include "transport/surface_photon_map.h"
#include "transport/volume_photon_map.h"

namespace brume {

/// What a method asks for.
struct PhotonMapRequest {
  std::uint64_t volumePhotons = 0;   ///< to store in media, of all classes together
  std::uint64_t surfacePhotons = 0;  ///< to store on surfaces, direct light apart
  bool unscatteredVolume = false;    ///< unscattered light in media is left to photons
  std::optional<int> maxDepth;       ///< most scatterings of a light path
};

/// The classes of photons that the scene can show to this request: none in media that do not
/// scatter, no caustics without mirror or glass, none on surfaces that are all specular.
PhotonClasses showableClasses(const Scene& scene, const PhotonMapRequest& request);

/// Traces about the numbers asked for. Where there is a choice of lights, or of the parts of the
/// scene that their paths are aimed at, pilots tell which of them make the noise of the image that
/// `context` knows of (PhotonDemand). Media and surfaces each have one number of light paths,
/// found by a pilot pass. Where the pilot meets next to nothing, as many paths as photons were
/// asked for are traced, four times over, and the log is told of the shortage: the photons stay
/// unbiased. Throws SceneError when unscattered light is left to photons and none is stored.
PhotonSet tracePhotons(const Scene& scene, const PhotonMapRequest& request,
                       const PrepareContext& context);

/// What there are no photons of, and why.
void planSkippedPhotons(const Scene& scene, Plan& plan);

/// One map of surface photons of all times does not suit surfaces that move: says so.
void warnOfMotion(const Scene& scene, const PrepareContext& context);

}  // namespace brume
