// SPDX-License-Identifier: Apache-2.0
// Light paths from the lights, and the photons that they leave behind: the one tracer of all photon
// methods.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <span>

#include "core/scene.h"
#include "transport/free_flight.h"
#include "transport/path_random.h"
#include "transport/photon.h"
#include "transport/photon_sources.h"

namespace brume {

/// What a method wants of the light paths.
struct PhotonRequest {
  PhotonClasses wanted{};
  Interval shutter{0, 1};         ///< times of the paths
  std::optional<int> maxDepth{};  ///< most scatterings of a path; unlimited when not given
  /// Media only attenuate: they emit nothing, and a path ends at its first collision.
  bool passiveMedia = false;
  /// Surfaces are looked for along every segment, even where none can be: for tests and benchmarks.
  bool looksEverywhere = false;
};

/// Number of paths from which the photons of each class are taken, the first ones of the pass.
using PathsPerClass = std::array<std::uint64_t, kPhotonClasses>;

/// Photons with powers divided by the number of paths of their class, in the order of their paths.
struct PhotonSet {
  std::vector<Photon> photons;
  PathsPerClass paths{};
  bool isComplete = true;  ///< false: `stop` was set, nothing in here may be used
};

/// Light paths: a light is chosen by the power it sends to the scene, its emission sampled, then
///   - free flights by inversion of the exact optical depth; at every collision a deposit, then
///     absorption or scattering by roulette on the albedo;
///   - at every surface with a lobe that is not specular a deposit; then the BSDF is sampled, with
///     the factor of shading normals for light that travels forwards (Veach 1997, 5.3)
///       |wo.ng| |wi.ns| / (|wi.ng| |wo.ns|),  wi to the light, wo the way the path goes on,
///     and (eta_i / eta_o)^2 where it is refracted: radiance is not scaled there (PBRT-v2);
///   - Russian roulette below the usual power (PhotonSources), so that photons have about equal
///     power.
/// Where the media are much smaller than the scene, paths are aimed at them: at the lights
/// (PhotonSources), and from surfaces outside of the ball around them, by the balance of a cone
/// towards it and of the BSDF's own directions.
/// No other estimator looks for the light of emitting media, so it counts as scattered from the
/// start (SurfaceIndirect, VolumeMultiple).
/// A path ends when nothing that is wanted can come of it. Photons that leave the scene are gone.
/// Some hundred paths advance together (PathWave), so that flights, collisions and random numbers
/// are vectors; what a path does depends on its own numbers alone.
/// Thread-safe but for setShares. Test: photon_tracer_test.
class PhotonTracer {
 public:
  PhotonTracer(const Scene& scene, const PhotonRequest& request);

  /// Whether any light sends photons.
  bool hasLights() const { return !sources_.isEmpty(); }

  /// The paths [0, paths of the class) of a pass, in parallel. The memory of `old` is used again.
  /// onShare(share) is called now and then, from any thread.
  PhotonSet trace(std::uint64_t seed, std::uint64_t pass, const PathsPerClass& paths,
                  const std::atomic<bool>& stop, Stats& stats, PhotonSet old = {},
                  const std::function<void(double)>& onShare = {}) const;

  /// What a path does for the image, squared, from its deposits, whose powers are as if it were the
  /// only path. Called in parallel.
  using SquareOfPath = std::function<double(std::span<const Photon>)>;
  /// The shares of paths from each of PhotonSources with the least noise: where paths of source s
  /// do c for the image, their noise is E[c^2 | s] / p(s), so
  ///   p(s) ~ p0(s) sqrt(E[c^2 | s]),   p0 the share so far
  /// learnt from a pilot, the first `count` paths of a pass. Sources that it knows little of take
  /// after the mean, and a part of the paths keeps to p0. None: there is nothing to choose, or
  /// `stop` was set.
  std::optional<std::vector<float>> learnShares(std::uint64_t seed, std::uint64_t pass,
                                                std::uint64_t count, const SquareOfPath& square,
                                                const std::atomic<bool>& stop, Stats& stats) const;
  /// Whether there is something to learn.
  bool hasShares() const { return sources_.count() > 1; }
  void setShares(std::span<const float> shares) { sources_.setShares(shares); }

 private:
  class Deposits;
  bool mayScatter(int scatterings) const {
    return !request_.maxDepth || scatterings < *request_.maxDepth;
  }
  Ball mediaToAimAt() const;
  void traceChunk(const PassRandom& random, std::int64_t begin, std::int64_t end,
                  const PathsPerClass& paths, Deposits& deposits, Stats& stats,
                  PathWave::Words* segments) const;
  void emit(PathRandom& random, PathWave& wave) const;
  void traceWave(PathWave& wave, Deposits& deposits, Stats& stats, PathWave::Words* segments) const;
  std::optional<SurfaceInteraction> fly(PathWave& wave, std::size_t i, Stats& stats) const;
  std::optional<SurfaceInteraction> endUniformFlight(PathWave& wave, std::size_t i,
                                                     Stats& stats) const;
  void meetSurfaces(int scatterings, PathWave& wave, Deposits& deposits, Stats& stats) const;
  bool scatterAtSurface(PathWave& wave, std::size_t i, const SurfaceInteraction& at,
                        int scatterings, Deposits& deposits) const;
  void depositInMedia(const PathWave& wave, Deposits& deposits) const;
  void scatterInMedia(int scatterings, PathWave& wave) const;

  const Scene& scene_;
  PhotonRequest request_;
  Bounds3 surfaces_;
  std::optional<UniformFlights> uniform_;  // all there is, where it is that simple
  std::optional<Rgb> albedo_;              // of all points, where the media are one
  std::optional<float> henyeyGreenstein_;  // likewise
  Ball media_;  // around those whose photons are wanted; radius 0: none are
  PhotonSources sources_;
};

}  // namespace brume
