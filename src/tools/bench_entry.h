// SPDX-License-Identifier: Apache-2.0
// The renders of a benchmark, each kept in a folder of its own so that an interrupted benchmark
// goes on where it was.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/log.h"
#include "tools/bench_config.h"

namespace brume {

/// The image at one moment of a render.
struct BenchPoint {
  double seconds = 0;     ///< by the clock, set-up of the integrator included, writing images not
  double cpuSeconds = 0;  ///< of all threads; 0: not known
  double samples = 0;     ///< per pixel; 0: not known
  std::optional<double> estimatedError;    ///< by the render itself (--error)
  std::map<std::string, double> counters;  ///< of --stats, those that are not 0
  std::string image;                       ///< file
};

/// One render: a scene by a method with a number of threads and a seed, or another renderer's.
struct BenchEntry {
  std::string scene, method;
  int threads = 0;  ///< 0: of another renderer
  std::uint64_t seed = 0;
  double setupSeconds = 0;
  std::uint64_t peakMemory = 0;    ///< of its process [bytes]; 0: not known
  std::string version, failure;    ///< the failure replaces points
  bool isFault = false;            ///< the failure is one of brume
  std::vector<BenchPoint> points;  ///< in order of time
};

/// The entry from its folder, when it was finished under the same conditions, else rendered in a
/// process of its own and kept there. None when `stop` was set before it was finished.
class BenchRunner {
 public:
  BenchRunner(const BenchConfig& config, std::string folder, const std::atomic<bool>& stop,
              std::function<void(const std::string&)> say)
      : config_(config), folder_(std::move(folder)), stop_(stop), say_(std::move(say)) {}

  std::optional<BenchEntry> entry(const BenchScene& scene, const BenchMethod& method, int threads,
                                  std::uint64_t seed);
  struct Reference {
    std::string file, failure;  ///< one of the two, none when `stop` was set
    bool isFault = false;
  };
  /// The file of the scene's reference, rendered when it is not there yet.
  Reference reference(const BenchScene& scene);

 private:
  const BenchConfig& config_;
  std::string folder_;
  const std::atomic<bool>& stop_;
  std::function<void(const std::string&)> say_;
};

/// Images that other renderers made: lines of name, scene, seconds, image file (relative to the
/// CSV's folder). A line that starts with # and a first line "name,scene,seconds,..." are skipped.
std::vector<BenchEntry> readForeignEntries(const std::string& csv, const BenchConfig& config);

}  // namespace brume
