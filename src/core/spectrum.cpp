// SPDX-License-Identifier: Apache-2.0
#include "core/spectrum.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/cie_1931.h"
#include "core/error.h"

namespace brume {

namespace {

/// Sum over the visible range of value(nm) times the matching functions, over the sum of y-bar.
template <class F>
Rgb integrate(F&& value) {
  double x = 0, y = 0, z = 0, sumY = 0;
  for (std::size_t i = 0; i < kCieSampleCount; ++i) {
    const CieSample& cie = kCie1931[i];
    const double v = value(double{kCieFirstWavelength} + static_cast<double>(i));
    x += v * static_cast<double>(cie.x);
    y += v * static_cast<double>(cie.y);
    z += v * static_cast<double>(cie.z);
    sumY += static_cast<double>(cie.y);
  }
  return rgbFromXyz(static_cast<float>(x / sumY), static_cast<float>(y / sumY),
                    static_cast<float>(z / sumY));
}

}  // namespace

Rgb rgbFromXyz(float x, float y, float z) {
  return {3.240479f * x - 1.537150f * y - 0.498535f * z,
          -0.969256f * x + 1.875991f * y + 0.041556f * z,
          0.055648f * x - 0.204043f * y + 1.057311f * z};
}

Rgb rgbFromSamples(std::span<const float> wavelengths, std::span<const float> values) {
  BRUME_CHECK(wavelengths.size() == values.size() && !values.empty());
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return wavelengths[a] < wavelengths[b]; });

  // The matching functions ask for rising wavelengths, so the segment only moves forward.
  std::size_t segment = 0;
  return integrate([&](double nm) -> double {
    const auto lambda = [&](std::size_t i) { return static_cast<double>(wavelengths[order[i]]); };
    const auto value = [&](std::size_t i) { return static_cast<double>(values[order[i]]); };
    if (nm <= lambda(0)) return value(0);
    while (segment + 1 < order.size() && lambda(segment + 1) < nm) ++segment;
    if (segment + 1 == order.size()) return value(segment);
    const double t = (nm - lambda(segment)) / (lambda(segment + 1) - lambda(segment));
    return (1 - t) * value(segment) + t * value(segment + 1);
  });
}

Rgb rgbFromBlackbody(float temperature) {
  if (!(temperature > 0)) return {};
  constexpr double kC2 = 1.4388e7;  // second radiation constant [nm K]
  constexpr double kNormalisedAt = 555;
  const double T = temperature;
  return integrate([&](double nm) {
    // expm1(a) / expm1(b), written so that neither overflows at low temperatures.
    const double a = kC2 / (kNormalisedAt * T), b = kC2 / (nm * T);
    const double planck = std::exp(a - b) * (-std::expm1(-a)) / (-std::expm1(-b));
    return std::pow(kNormalisedAt / nm, 5.0) * planck;
  });
}

}  // namespace brume
