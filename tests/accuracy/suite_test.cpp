// SPDX-License-Identifier: Apache-2.0
// The suites' own yardsticks: both ways to a standard error, and that a wrong mean is seen.
#include "support/suite.h"

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include "support/boxes.h"

namespace brume::test {
namespace {

const SuiteScene kFurnace = {
    kFromOutside, sky() + equalMedia("\"color sigma_s\" [2 2 2] \"float g\" .4")[0].text};

TEST(Suite, WholeRendersAndPixelsGiveTheSameStandardError) {
  Method byPixels = judgedMethods().front(), byRenders = byPixels;
  byRenders.pixelsAreIndependent = false;
  const Goal goal{0.01, 20000};
  const Measurement a = measure(byPixels, kFurnace, goal), b = measure(byRenders, kFurnace, goal);
  for (std::size_t c = 0; c < 3; ++c) {
    const Estimate &x = a.channels[c], &y = b.channels[c];
    EXPECT_LT(std::abs(x.z(y)), 4);
    // The variance of one sample; that from 16 renders is uncertain by 1/sqrt(30) of itself.
    const double vx = x.standardError * x.standardError * static_cast<double>(a.samples);
    const double vy = y.standardError * y.standardError * static_cast<double>(b.samples);
    EXPECT_NEAR(vy / vx, 1, 4 / std::sqrt(30.0));
  }
}

TEST(Suite, GoalsAreReached) {
  const Measurement m = measure(judgedMethods().front(), kFurnace, {0.004});
  for (const Estimate& e : m.channels) EXPECT_LE(e.standardError, 0.0042 * e.mean);
  EXPECT_LT(m.samples, 2'000'000);
}

TEST(Suite, WrongMeansAreSeen) {
  Measurement m;
  m.channels = {Estimate{1, 0.002}, Estimate{1, 0.002}, Estimate{1, 0.002}};
  expectMeans(m, {1.005, 1, 0.995}, Form::Full, "within three standard errors");
  EXPECT_NONFATAL_FAILURE(expectMeans(m, {1, 1.0065, 1}, Form::Full, "too dark"), "too dark");
  EXPECT_NONFATAL_FAILURE(expectMeans(m, {1, 1, 0.9935}, Form::Full, "too bright"), "too bright");
  m.channels[1].standardError = 0.004;
  EXPECT_NONFATAL_FAILURE(expectMeans(m, gray3(1), Form::Full, "noisy"), "noisy");
  m.channels[1].standardError = 0.001;
  m.faults = 1;
  EXPECT_NONFATAL_FAILURE(expectMeans(m, gray3(1), Form::Full, "NaN"), "NaN");
}

}  // namespace
}  // namespace brume::test
