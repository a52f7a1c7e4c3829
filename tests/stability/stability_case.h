// SPDX-License-Identifier: Apache-2.0
// One line of the stability suite: a scene rendered in two forms that must show the same.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "support/suite.h"

namespace brume::test {

/// What a case found.
struct StabilityResult {
  /// Largest relative difference of a channel's mean to what it should be.
  double difference = 0;
  /// How much of that may be noise: standard error of the difference, relative.
  double noise = 0;
  /// NaN, infinite and negative radiances.
  std::uint64_t faults = 0;
};

struct StabilityCase {
  std::string group, name;
  /// Largest relative difference that is not noise, and its reason.
  double tolerance;
  std::string reason;
  /// Largest noise with which the case still says something.
  double maxNoise;
  std::function<StabilityResult(Form)> run;
};

/// Samples per pixel and pixels per side of an image of a case.
int caseSamples(Form form);
constexpr int kCasePixels = 24;

/// Renders both scene texts with the same random numbers and compares pixel by pixel: as long as
/// the same paths are followed, only rounding differs. `factor` is how much brighter the second is.
StabilityResult comparePaired(const std::string& base, const std::string& transformed,
                              double factor = 1);
/// A scene whose pixels all see the same against exact values.
StabilityResult compareExact(const std::string& scene, const std::array<double, 3>& expected);

// The cases, by file.
std::vector<StabilityCase> scaleCases();
std::vector<StabilityCase> mediumCases();
std::vector<StabilityCase> geometryCases();
std::vector<StabilityCase> lightCases();
std::vector<StabilityCase> allStabilityCases();

}  // namespace brume::test
