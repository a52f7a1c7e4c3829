// SPDX-License-Identifier: Apache-2.0
// From a parsed frame to an image: makes camera, sampler, film and integrators, runs the passes,
// reports progress.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/deferred.h"
#include "core/film.h"
#include "core/integrator.h"
#include "core/parse/scene_description.h"
#include "core/registry.h"

namespace brume {

/// What the command line asks for, beside what the scene says.
struct RenderSettings {
  std::uint64_t seed = 0;
  bool quick = false;
  std::string outputName;                    ///< -o; empty: the scene's
  std::optional<Vec2i> resolution;           ///< --resolution
  std::optional<std::array<float, 4>> crop;  ///< --crop
  std::optional<int> samplesPerPixel;        ///< --spp
  std::optional<int> passes;          ///< --passes: full rounds of samples per pixel; default 1
  std::optional<double> maxSeconds;   ///< --time
  std::optional<double> targetError;  ///< --error: stop when the estimated relative error is below
  bool variance = false;              ///< write variance layers
  bool layers = false;                ///< write components, depth, normal, albedo, transmittance
  std::vector<std::string> integrators;  ///< --integrator NAME[:key=value,...]
};

struct RenderProgress {
  std::string_view what = {};  ///< is done before the first pass; empty: passes
  double fraction = 0;         ///< of the work, 0..1, as far as it is known
  int pass = 0;
  double seconds = 0;
  std::uint64_t rays = 0, photons = 0;
  std::optional<double> estimatedError;
};

/// RenderJob::run shows the image whenever the samples per pixel, or passes, have grown by this
/// factor: evenly spaced where error is plotted against time on logarithmic axes.
inline constexpr double kSnapshotGrowth = 1.41421356;

enum class StopReason { Done, Time, Error, Interrupted };

struct RenderResult {
  LayeredImage image;  ///< with metadata: scene parameters, seed, passes, seconds, version
  Stats stats;
  StopReason reason = StopReason::Done;
  int passes = 0;
  std::int64_t samples = 0;              ///< per average pixel
  std::optional<double> estimatedError;  ///< relative, where the film keeps variances
  double seconds = 0;                    ///< of the render
  double setupSeconds = 0;  ///< of making the RenderJob: acceleration structures, integrators
};

/// One frame to be rendered.
class RenderJob {
 public:
  /// Makes everything the frame needs; throws SceneError for what the scene or the settings got
  /// wrong.
  RenderJob(SceneDescription description, const RenderSettings& settings, Log& log);
  ~RenderJob();

  /// Renders until done or stop is set. `progress` is called from one thread at a time, a few times
  /// a second at most; `snapshot` at growing intervals (kSnapshotGrowth) with the image so far. The
  /// time it takes is not counted. When the render fails (SceneError where the file of a texture is
  /// found broken at its first lookup), `rescue` gets the image that was finished before, if there
  /// is one, and the failure is thrown.
  RenderResult run(const std::atomic<bool>& stop,
                   const std::function<void(const RenderProgress&)>& progress,
                   const std::function<void(const RenderResult&)>& snapshot = {},
                   const std::function<void(const RenderResult&)>& rescue = {});

  /// Whether the image is made by passes, each of which improves all of it.
  bool isProgressive() const;
  const Film& film() const;
  const Scene& scene() const;
  /// Each plugin in use with its effective parameters, for metadata and statistics.
  struct UsedPlugin {
    std::string kind, name;
    std::vector<ParamRecord> params;
  };
  const std::vector<UsedPlugin>& plugins() const;
  /// What the scene has, what is built, what is skipped and why: --plan. After run() it knows which
  /// files nothing looked at.
  std::vector<std::string> plan() const;
  /// Files of textures and materials that have been read, and those that wait for a first lookup.
  DeferredCounts files() const;
  /// Reads the latter too, and those that the integrator would read, as a check; but not those that
  /// are still to be written. Throws SceneError.
  void readAllFiles(const std::set<std::string>& toBeWritten = {}) const;
  /// Files that the render writes before its image.
  std::vector<std::string> outputs() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace brume
