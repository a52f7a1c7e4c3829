// SPDX-License-Identifier: Apache-2.0
// The camera's side of one progressive pass: a sample per pixel, its beams, and what it sees
// without photons in media.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "accelerators/beam_lookup.h"
#include "core/reuse.h"
#include "transport/blur_monitor.h"
#include "transport/camera_path.h"

namespace brume {

class SurfacePhotonMap;

/// What a beam adds to.
struct BeamOwner {
  std::uint32_t sample = 0;  ///< of CameraBeams::samples
  Rgb weight;                ///< of radiance at the beam's t0 on its way to the pixel
  float time = 0;            ///< of the camera ray
};

/// Beams with their owners, in the same order.
struct OwnedBeams {
  std::vector<Beam> beams;
  std::vector<BeamOwner> owners;
  void resize(std::size_t count) {
    resizeForReuse(beams, count);
    resizeForReuse(owners, count);
  }
  /// Moves `count` beams to a place before or at their own.
  void move(std::size_t from, std::size_t count, std::size_t to) {
    if (from == to || count == 0) return;
    std::copy_n(beams.begin() + static_cast<std::ptrdiff_t>(from), count,
                beams.begin() + static_cast<std::ptrdiff_t>(to));
    std::copy_n(owners.begin() + static_cast<std::ptrdiff_t>(from), count,
                owners.begin() + static_cast<std::ptrdiff_t>(to));
  }
  /// Puts others in the place of its own ones from `to` on.
  void replace(std::size_t to, const OwnedBeams& o) {
    std::copy(o.beams.begin(), o.beams.end(), beams.begin() + static_cast<std::ptrdiff_t>(to));
    std::copy(o.owners.begin(), o.owners.end(), owners.begin() + static_cast<std::ptrdiff_t>(to));
  }
};

struct CameraBeams {
  struct Sample {
    Vec2 raster{0};
    Rgb L;  ///< without volume photons at first; pvpm adds what the beams gather
  };
  /// A rectangle of pixels and its samples: [first, end).
  struct Tile {
    Bounds2i pixels;
    std::size_t first = 0, end = 0;
  };
  /// What a probe of a BlurMonitor looks through.
  struct Probe {
    std::uint32_t sample = 0;
    Rgb beforeBeams;  ///< L without volume photons
    Rgb surfaces;     ///< the part of surface photons
  };
  std::vector<Sample> samples;  ///< tile by tile
  std::vector<Probe> probes;    ///< when asked for
  std::vector<Tile> tiles;
  OwnedBeams primary;    ///< straight from the camera; Beam::pixel counts in `pixels`
  OwnedBeams secondary;  ///< behind mirrors and glass
  Bounds2i pixels;       ///< that were sampled
};

/// How the beams of a pass are made.
struct CameraBeamOptions {
  float beamRadius = 0;                       ///< of all beams, unless each pixel has its own
  std::span<const float> pixelRadii;          ///< by Beam::pixel, or empty
  bool wantsBeams = true;                     ///< there are photons for them
  bool throughCentres = false;                ///< fixed beams instead of jittered ones
  std::optional<float> moment;                ///< time of all camera rays, part of the shutter
  const SurfacePhotonMap* surface = nullptr;  ///< photons on surfaces, or none
  float surfaceRadius = 0;
  const BlurMonitor* monitor = nullptr;  ///< whose probes are wanted, or none
};

/// The light of a pass in the monitor's probes, once the beams have gathered theirs.
std::vector<ProbeLight> probeLight(const CameraBeams& beams);

/// Adds the samples to the film, tile by tile in order, as one pass.
void addToFilm(const CameraBeams& beams, Film& film);

/// Traces one camera path through every pixel, in parallel; its light is gathered by `paths` and
/// from the surface photons. The memory of `old` is used again. Empty samples when `stop` was set.
CameraBeams traceCameraBeams(const PassContext& context, const CameraPaths& paths,
                             const CameraBeamOptions& options, CameraBeams old = {});

}  // namespace brume
