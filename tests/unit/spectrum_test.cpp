// SPDX-License-Identifier: Apache-2.0
#include "core/spectrum.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/cie_1931.h"

namespace brume {
namespace {

TEST(Spectrum, MatchingFunctionsSumToPublishedValues) {
  double x = 0, y = 0, z = 0;
  for (const CieSample& s : kCie1931) {
    x += static_cast<double>(s.x);
    y += static_cast<double>(s.y);
    z += static_cast<double>(s.z);
  }
  // Sums over 360..830 nm at 1 nm of the CIE 1931 tables, given to 6 decimals.
  EXPECT_NEAR(x, 106.865469, 1e-4);
  EXPECT_NEAR(y, 106.856895, 1e-4);
  EXPECT_NEAR(z, 106.892251, 1e-4);
}

TEST(Spectrum, EqualEnergyIsNotWhite) {
  const std::vector<float> lambda{500}, value{1};
  const Rgb c = rgbFromSamples(lambda, value);
  // Row sums of the XYZ to RGB matrix; X, Y and Z of equal energy differ by 4e-4.
  EXPECT_NEAR(c.r, 1.205f, 2e-3f);
  EXPECT_NEAR(c.g, 0.948f, 2e-3f);
  EXPECT_NEAR(c.b, 0.909f, 2e-3f);
}

TEST(Spectrum, SamplesNeedNoOrderAndExtendAtTheEnds) {
  const std::vector<float> sorted{400, 500, 600}, values{1, 3, 2};
  const std::vector<float> shuffled{600, 400, 500}, same{2, 1, 3};
  EXPECT_EQ(rgbFromSamples(sorted, values), rgbFromSamples(shuffled, same));
  const std::vector<float> extended{100, 400, 500, 600, 2000}, ends{1, 1, 3, 2, 2};
  const Rgb a = rgbFromSamples(sorted, values), b = rgbFromSamples(extended, ends);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-6f);
}

TEST(Spectrum, InterpolationIsLinear) {
  // A straight line sampled twice or at every nm is the same line.
  std::vector<float> lambda, value;
  for (int nm = 360; nm <= 830; ++nm) {
    lambda.push_back(static_cast<float>(nm));
    value.push_back(static_cast<float>(nm) * 0.01f);
  }
  const std::vector<float> ends{360, 830}, endValues{3.6f, 8.3f};
  const Rgb a = rgbFromSamples(lambda, value), b = rgbFromSamples(ends, endValues);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-5f * std::abs(a[i]));
}

TEST(Spectrum, DuplicateWavelengthsAreASteps) {
  const std::vector<float> lambda{550, 550}, value{0, 1};
  const Rgb c = rgbFromSamples(lambda, value);
  EXPECT_TRUE(c.isFinite());
  const std::vector<float> near{549.999f, 550.001f};
  const Rgb d = rgbFromSamples(near, value);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(c[i], d[i], 0.02f);  // one nm of the table
}

TEST(Spectrum, XyzMatrixGivesWhiteForD65) {
  const Rgb white = rgbFromXyz(0.950456f, 1.f, 1.088754f);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(white[i], 1.f, 2e-4f);
}

TEST(Spectrum, BlackbodyIsNormalisedAndReddensWhenCool) {
  EXPECT_EQ(rgbFromBlackbody(0), Rgb());
  EXPECT_EQ(rgbFromBlackbody(-5), Rgb());
  const Rgb candle = rgbFromBlackbody(2000), sky = rgbFromBlackbody(10000);
  EXPECT_GT(candle.r, 2 * candle.b);
  EXPECT_GT(sky.b, sky.r);
  // At very high temperature the curve is (555 nm / lambda)^4 (Rayleigh-Jeans, times 1 at 555 nm).
  std::vector<float> lambda, value;
  for (int nm = 360; nm <= 830; ++nm) {
    lambda.push_back(static_cast<float>(nm));
    value.push_back(std::pow(555.f / static_cast<float>(nm), 4.f));
  }
  const Rgb limit = rgbFromSamples(lambda, value), hot = rgbFromBlackbody(1e9f);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(hot[i], limit[i], 1e-3f * limit[i]);
}

}  // namespace
}  // namespace brume
