// SPDX-License-Identifier: Apache-2.0
// What `brume bench FILE.json` is asked to measure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/math.h"

namespace brume {

/// Where the truth about a scene comes from: a file, or a long render.
struct BenchReference {
  std::string file;                      ///< an image; empty: rendered
  std::vector<std::string> integrators;  ///< as --integrator
  std::optional<int> passes;
  std::optional<double> seconds;  ///< by the clock
  std::uint64_t seed = 0;
};

struct BenchScene {
  std::string name, file;
  std::optional<Vec2i> resolution;
  std::optional<int> samplesPerPixel;
  BenchReference reference;
  std::vector<std::string> methods;  ///< names; empty: all
};

/// An integrator with its parameters, and optionally limits of its own.
struct BenchMethod {
  std::string name;
  std::vector<std::string> integrators;  ///< as --integrator; empty: the scene's own
  std::optional<int> passes;
  std::optional<double> seconds;
};

struct BenchConfig {
  std::string title, file;
  std::vector<BenchScene> scenes;
  std::vector<BenchMethod> methods;
  std::string baseline;       ///< a method's name: ratios are to it
  std::optional<int> passes;  ///< limits of each render; the first that is reached
  std::optional<double> seconds;
  std::vector<int> threads;          ///< one render for each
  std::vector<std::uint64_t> seeds;  ///< one render for each
  std::string foreign;               ///< CSV file of other renderers' images; empty: none

  bool runs(const BenchScene& scene, const BenchMethod& method) const;
};

/// Relative file names are resolved against the file's folder. Throws SceneError for what is wrong
/// or missing. docs/benchmarks.md is the manual of the keys.
BenchConfig readBenchConfig(const std::string& path);

}  // namespace brume
