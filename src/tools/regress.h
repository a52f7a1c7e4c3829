// SPDX-License-Identifier: Apache-2.0
// `brume regress DIR`: renders the scenes of a folder and compares each with its reference.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "core/log.h"

namespace brume {

struct RegressOptions {
  std::string folder;
  std::vector<std::string> scenes;          ///< names without .pbrt; empty: all of the folder
  bool update = false;                      ///< write references instead of comparing
  std::string output = "regress-failures";  ///< folder for what failed
};

/// How much work and how much difference; the keys of FOLDER/regress.json, for all scenes or for
/// one. docs/regression.md is their manual.
struct RegressRules {
  std::vector<std::string> integrators;           ///< as --integrator; empty: the scene's
  std::vector<std::string> referenceIntegrators;  ///< empty: as the image
  int passes = 1;                                 ///< rounds of the scene's samples per pixel
  int referencePasses = 32;
  /// Chance that an image without fault fails. None: no z-test.
  std::optional<double> zTest = 1e-4;
  int block = 4;  ///< side of the squares whose means are z-tested too [pixels]; 1: none
  std::optional<double> maxRelMse, maxFlip, maxMeanRatioError;
};

/// One scene, compared.
struct RegressResult {
  std::string name;
  std::vector<std::string> failures;  ///< in words; empty: passed
  std::string figures;                ///< one line
  double seconds = 0;
  bool passed() const { return failures.empty(); }
};

struct RegressOutcome {
  std::vector<RegressResult> results;
  bool isInterrupted = false;
  bool passed() const;
};

/// Renders, compares or updates; `say` gets a line for each scene. A scene that cannot be read or
/// rendered, or has no reference, is a failure of that scene. What failed is left in
/// options.output: NAME.exr, NAME.png, NAME.reference.png, NAME.difference.png, NAME.p.png and
/// index.html. Throws SceneError for a folder without scenes and a bad regress.json.
RegressOutcome regress(const RegressOptions& options, Log& log, const std::atomic<bool>& stop,
                       const std::function<void(const std::string&)>& say);

}  // namespace brume
