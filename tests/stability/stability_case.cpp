// SPDX-License-Identifier: Apache-2.0
#include "stability/stability_case.h"

#include <algorithm>
#include <cmath>

#include "support/render_text.h"

namespace brume::test {

namespace {

constexpr const char* kChannels[3] = {"R", "G", "B"};

}  // namespace

int caseSamples(Form form) { return form == Form::Full ? 128 : 32; }

StabilityResult comparePaired(const std::string& base, const std::string& transformed,
                              double factor) {
  const RenderResult a = renderText(base), b = renderText(transformed);
  StabilityResult result;
  result.faults = faultsOf(a.stats) + faultsOf(b.stats);
  for (const char* name : kChannels) {
    const auto &x = a.image.channels.at(name), &y = b.image.channels.at(name);
    const double n = static_cast<double>(x.size());
    double mean = 0, difference = 0, squares = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double d = double{y[i]} / factor - double{x[i]};
      mean += double{x[i]} / n;
      difference += d / n;
      squares += d * d / n;
    }
    if (mean == 0 && difference == 0) continue;
    const double variance = std::max(0.0, squares - difference * difference) / (n - 1);
    result.difference = std::max(result.difference, std::abs(difference) / mean);
    result.noise = std::max(result.noise, std::sqrt(variance) / mean);
  }
  return result;
}

StabilityResult compareExact(const std::string& scene, const std::array<double, 3>& expected) {
  const RenderResult r = renderText(scene);
  StabilityResult result;
  result.faults = faultsOf(r.stats);
  for (std::size_t c = 0; c < 3; ++c) {
    const Estimate e = estimateOf(r.image, kChannels[c]);
    const double scale = expected[c] != 0 ? std::abs(expected[c]) : 1;
    result.difference = std::max(result.difference, std::abs(e.mean - expected[c]) / scale);
    result.noise = std::max(result.noise, e.standardError / scale);
  }
  return result;
}

std::vector<StabilityCase> allStabilityCases() {
  std::vector<StabilityCase> all;
  for (const auto& cases : {scaleCases(), mediumCases(), geometryCases(), lightCases()})
    all.insert(all.end(), cases.begin(), cases.end());
  return all;
}

}  // namespace brume::test
