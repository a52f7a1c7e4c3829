// SPDX-License-Identifier: Apache-2.0
// Light paths that advance together, a segment of each at a time.
#pragma once

#include <array>

#include "core/math.h"
#include "core/rgb.h"
#include "core/rng.h"

namespace brume {

/// Some light paths, each a lane of arrays, and the segment that each is about to fly. All have as
/// many scatterings behind them, so they are at the same dimension of their random numbers.
/// Loops over `lanes()` are whole vectors; what they compute in lanes beyond `count` is not used.
struct PathWave {
  static constexpr std::size_t kSize = 256;
  using Floats = std::array<float, kSize>;
  using Words = std::array<std::uint32_t, kSize>;
  struct Vectors {
    alignas(32) Floats x, y, z;
    Vec3 operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
    void set(std::size_t i, const Vec3& v) { x[i] = v.x, y[i] = v.y, z[i] = v.z; }
  };
  struct Colours {
    alignas(32) Floats r, g, b;
    Rgb operator[](std::size_t i) const { return {r[i], g[i], b[i]}; }
    void set(std::size_t i, const Rgb& c) { r[i] = c.r, g[i] = c.g, b[i] = c.b; }
    void fill(const Rgb& c) { r.fill(c.r), g.fill(c.g), b.fill(c.b); }
  };

  std::size_t count = 0;

  // The paths.
  Vectors o, d;  ///< of the next segment, render space
  alignas(32) Floats time;
  Colours power;                  ///< alpha [W]
  alignas(32) Floats usualPower;  ///< largest channel of the power that photons should have [W]
  alignas(32) Words canStore;  ///< bits of the PhotonClasses that it may still store, wanted or not
  alignas(32) Words isInMedium;       ///< o was reached by scattering in it, or emission: 1, else 0
  alignas(32) Words wanted;           ///< bits of PhotonClasses
  alignas(32) Words path;             ///< number within the wave
  alignas(32) Words keyLow, keyHigh;  ///< PathRandom::key

  // Their random numbers for one segment and the scattering at its end, in the order of dimensions.
  alignas(32) Floats uChannel, uDepth;  // the flight
  alignas(32) Floats u1, u2;            // roulette and choices
  alignas(32) Floats ux, uy;            // direction

  // The segment.
  alignas(32) Floats t;                   ///< of the collision in the media; infinity: none
  alignas(32) Floats mediaFrom, mediaTo;  ///< where the segment is in uniform media
  Colours channels;                       ///< that may have drawn t, their probabilities
  Colours albedo;                         ///< at t
  Vectors p;                              ///< ray(t)
  alignas(32) Words wi;                   ///< PackedDirection of -d
  alignas(32) Words mayMeetSurface;       ///< 0: no surface lies before t
  alignas(32) Floats isAlive;             ///< 1 after the scattering at its end, 0: ended there

  /// `count` in whole vectors.
  std::size_t lanes() const { return (count + 7) & ~std::size_t{7}; }
  bool collides(std::size_t i) const { return t[i] < kInfinity; }
};

/// The random numbers of a segment, four dimensions from `dimension` on (Rng).
void drawNumbers(std::uint64_t dimension, PathWave& wave);

/// Drops the paths that are not alive or can store nothing that is wanted. The others stay in
/// order.
void dropEnded(PathWave& wave);

/// The box around all surfaces against the segments up to t: sets mayMeetSurface.
void findSegmentsNear(const Bounds3& surfaces, PathWave& wave);

/// At the collisions: their places, and the directions from where they were met.
void arriveInMedia(PathWave& wave);

/// Absorption or scattering of the paths that collide, by roulette on power times albedo, so that
/// survivors have the usual power at least; but no more than `mostSurvive` of them do. Sets power,
/// isAlive.
void rouletteInMedia(float mostSurvive, PathWave& wave);

/// New directions of the paths that collide by a Henyey-Greenstein phase function (HG 1941), whose
/// value is the density. Sets o, d, isInMedium, and canStore to what scattered paths can.
void scatterInMedia(float g, std::uint32_t canStore, PathWave& wave);

}  // namespace brume
