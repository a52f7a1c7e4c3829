// SPDX-License-Identifier: Apache-2.0
// What the accuracy and stability suites share: the integrators they judge, scenes whose pixels all
// see the same, and means measured to a wanted precision.
#pragma once

#include <array>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "core/stats.h"
#include "support/estimate.h"

namespace brume::test {

/// Quick: seconds, in every ./check. Full: what the issue asks for, in ./check --full.
enum class Form { Quick, Full };

/// An integrator that the suites judge.
struct Method {
  std::string name;       ///< in the names of tests
  std::string directive;  ///< in the scene
  /// Pixels share no random event, so that their scatter gives the standard error; else whole
  /// renders with other seeds do.
  bool pixelsAreIndependent = true;
  /// Half-width of the slabs, in their thickness: infinite, for a method that can look at a spot.
  double slabExtent = 1e4;
};
inline void PrintTo(const Method& method, std::ostream* out) { *out << method.name; }
/// One row for each integrator that claims to find all light in media.
const std::vector<Method>& judgedMethods();

/// A scene without its film, sampler and integrator. All pixels see the same: the field of view is
/// tiny.
struct SuiteScene {
  std::string lookAt;  ///< nine numbers
  std::string world;
  double fov = 0.001;
};
std::string sceneText(const Method& method, const SuiteScene& scene, int pixels, int samples);

/// Means of the three channels; faults: NaN, infinite and negative radiances that were counted.
struct Measurement {
  std::array<Estimate, 3> channels;
  std::uint64_t faults = 0;
  std::int64_t samples = 0;
};
std::uint64_t faultsOf(const Stats& stats);

/// Renders until the standard error of each channel is below `relativeError` of its mean, or
/// `maxSamples` camera rays are spent. A pilot render chooses the number of samples and does not
/// count.
struct Goal {
  double relativeError = 0.01;
  std::int64_t maxSamples = std::int64_t{1} << 25;
  std::uint64_t seed = 0;  ///< other random numbers, where two measurements must be independent
};
Measurement measure(const Method& method, const SuiteScene& scene, const Goal& goal);

/// What a suite demands of a mean. Full (the words): within 0.3 % or three standard errors,
/// whichever is larger, the standard error below 0.3 %. Quick: four standard errors (fails by
/// chance once in 16,000), the standard error below 1.5 %.
struct Demand {
  double maxStandardError;  ///< relative
  double tolerance;         ///< relative
  double maxZ;
};
Demand demandOf(Form form);
/// Expects faults = 0, and the means to be `expected` (exact) by that demand.
void expectMeans(const Measurement& m, const std::array<double, 3>& expected, Form form,
                 const std::string& what);
/// measure() with the precision the form demands, then expectMeans().
void expectRadiance(const Method& method, const SuiteScene& scene,
                    const std::array<double, 3>& expected, Form form, const std::string& what);
inline std::array<double, 3> gray3(double v) { return {v, v, v}; }

// Pieces of scene text.
std::string rgbText(const std::array<double, 3>& v);
std::string rgbText(double v);
/// A constant sky.
std::string sky(const std::array<double, 3>& L = {1, 1, 1});
/// A matte rectangle at height z, 2 half wide.
std::string floorAt(double z, double half, double Kd);

/// Letters, digits and underscores, as names of tests must be.
std::string asTestName(std::string text);

}  // namespace brume::test
