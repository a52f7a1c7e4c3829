// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tools/image_metrics.h"

namespace brume {
namespace {

constexpr std::array<const char*, 3> kColors{"R", "G", "B"};
constexpr std::array<const char*, 3> kVariances{"variance.R", "variance.G", "variance.B"};

/// P(|N(0,1)| >= |z|).
double twoSidedP(double z) { return std::erfc(std::abs(z) / std::numbers::sqrt2); }

/// P(at least one of n independent p-values is <= p).
double sidak(double p, double n) { return p >= 1 ? 1 : -std::expm1(n * std::log1p(-p)); }

/// Asymptotic Kolmogorov distribution: P(sqrt(n) D > x) = 2 sum_k (-1)^(k-1) exp(-2 k^2 x^2).
double kolmogorovP(double x) {
  if (x < 0.2) return 1;  // the sum equals 1 to 1e-12 there but converges slowly
  double sum = 0;
  for (int k = 1; k <= 100; ++k) {
    const double term = std::exp(-2. * k * k * x * x);
    sum += k % 2 ? term : -term;
    if (term < 1e-16) break;
  }
  return std::clamp(2 * sum, 0., 1.);
}

/// Largest distance between the empirical distribution of z and the normal one.
double ksDistance(std::vector<float>& z) {
  std::sort(z.begin(), z.end());
  const double n = static_cast<double>(z.size());
  double largest = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    const double cdf = .5 * std::erfc(-z[i] / std::numbers::sqrt2);
    const double below = cdf - static_cast<double>(i) / n;
    const double above = static_cast<double>(i + 1) / n - cdf;
    largest = std::max({largest, below, above});
  }
  return largest;
}

}  // namespace

bool hasVariance(const LayeredImage& image) {
  return std::all_of(kVariances.begin(), kVariances.end(),
                     [&](const char* name) { return image.has(name); });
}

std::optional<ZTest> zTest(const LayeredImage& a, const LayeredImage& b) {
  constexpr double kFixedTolerance = 1e-4;
  // Equal samples add up to a variance of rounding: no noise to compare a difference with.
  constexpr double kRounding = 1e-6;
  if (!hasVariance(a) || !hasVariance(b)) return std::nullopt;
  const int width = a.dataWindow.width(), height = a.dataWindow.height();
  if (width != b.dataWindow.width() || height != b.dataWindow.height())
    throw SceneError("the images differ in size");

  ZTest result;
  result.pValues = ScalarImage(width, height);
  std::fill(result.pValues.values.begin(), result.pValues.values.end(), 1.f);
  std::vector<float> all;
  double sum = 0, sumSquares = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto &xa = a.channels.at(kColors[c]), &xb = b.channels.at(kColors[c]);
    const auto &va = a.channels.at(kVariances[c]), &vb = b.channels.at(kVariances[c]);
    for (std::size_t i = 0; i < xa.size(); ++i) {
      const double difference = double{xa[i]} - xb[i], variance = double{va[i]} + vb[i];
      float& pixelP = result.pValues.values[i];
      const double size = std::max(std::abs(double{xa[i]}), std::abs(double{xb[i]}));
      if (variance <= sqr(kRounding * size)) {
        ++result.fixed;
        if (!(std::abs(difference) <= kFixedTolerance * size)) {
          ++result.fixedDiffer;
          pixelP = 0;
        }
        continue;
      }
      double z = difference / std::sqrt(variance);
      if (std::isnan(z)) z = kInfinity;
      ++result.tests;
      all.push_back(static_cast<float>(z));
      sum += z;
      sumSquares += z * z;
      pixelP = std::min(pixelP, static_cast<float>(twoSidedP(z)));
      if (std::abs(z) > result.maxAbsZ) {
        result.maxAbsZ = std::abs(z);
        result.maxPixel = {static_cast<int>(i % static_cast<std::size_t>(width)),
                           static_cast<int>(i / static_cast<std::size_t>(width))};
        result.maxChannel = static_cast<int>(c);
      }
    }
  }
  if (result.tests == 0) return result;
  const double n = static_cast<double>(result.tests);
  result.sidakP = sidak(twoSidedP(result.maxAbsZ), n);
  result.meanZ = sum / n;
  result.meanZP = twoSidedP(std::sqrt(n) * result.meanZ);
  result.meanZ2 = sumSquares / n;
  result.ksDistance = ksDistance(all);
  result.ksP = kolmogorovP(std::sqrt(n) * result.ksDistance);
  return result;
}

ScalarImage significanceMap(const ScalarImage& pValues) {
  constexpr float kDecades = 10;
  ScalarImage map(pValues.width, pValues.height);
  std::transform(pValues.values.begin(), pValues.values.end(), map.values.begin(),
                 [](float p) { return p > 0 ? -std::log10(p) / kDecades : 1.f; });
  return map;
}

}  // namespace brume
