// SPDX-License-Identifier: Apache-2.0
#include "tools/bench_curve.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/rng.h"

namespace brume {
namespace {

/// A normal number from two uniform ones (Box and Muller 1958).
float normal(Rng& rng) {
  return std::sqrt(-2 * std::log(1 - rng.uniform())) * std::cos(2 * kPi * rng.uniform());
}

TEST(BenchCurve, TheNoiseOfTheReferenceIsSubtracted) {
  // The truth is 2 everywhere; image and reference deviate by independent noise.
  constexpr int kSide = 200;
  constexpr float kTruth = 2, kImageSigma = 0.02f, kReferenceSigma = 0.05f;
  Rng rng(1);
  RgbImage image(kSide, kSide);
  Truth truth{RgbImage(kSide, kSide), {}};
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      image.pixels[i][c] = kTruth + kImageSigma * normal(rng);
      truth.image.pixels[i][c] = kTruth + kReferenceSigma * normal(rng);
    }
  const double biased = measurePoint(image, truth).relMse;
  truth.variance.assign(image.pixels.size(), Rgb(kReferenceSigma * kReferenceSigma));
  const double scale = kTruth * kTruth + 0.01;
  EXPECT_NEAR(truth.relMseNoise(), kReferenceSigma * kReferenceSigma / scale, 3e-6);
  EXPECT_NEAR(biased, (4e-4 + 25e-4) / scale, 2e-5);
  // Standard deviation of the mean of 120000 squares: sqrt(2 / 120000) 29e-4 / scale = 3e-6.
  EXPECT_NEAR(measurePoint(image, truth).relMse, 4e-4 / scale, 1.5e-5);
  EXPECT_NEAR(measurePoint(image, truth).meanRatio, 1, 1e-3);
  const double relativeScale = kTruth * kTruth * 1.01;
  EXPECT_NEAR(sqr(measurePoint(image, truth).relative), 4e-4 / relativeScale, 1.5e-5);
}

TEST(BenchCurve, ReachesOnAStraightLineOfLogarithms) {
  const std::vector<CurveSample> curve{{1, 1}, {2, .5}, {4, .25}, {16, .0625}};  // error = 1 / x
  EXPECT_NEAR(reach(curve, .3).value(), 1 / .3, 1e-12);
  EXPECT_NEAR(reach(curve, .1).value(), 10, 1e-12);
  EXPECT_EQ(reach(curve, 2).value(), 1);
  EXPECT_FALSE(reach(curve, .01));
  EXPECT_FALSE(reach({}, .01));
  // An error below the reference's noise still has a time.
  const auto below = reach({{1, .1}, {2, -1e-5}}, .01);
  ASSERT_TRUE(below);
  EXPECT_GT(*below, 1);
  EXPECT_LT(*below, 2);
}

TEST(BenchCurve, TargetsAreRoundAndReached) {
  const std::vector<CurveSample> curve{{1, .5}, {10, .02}, {20, .025}};
  EXPECT_EQ(targetsOf(curve, 9).size(), 3u);
  EXPECT_NEAR(targetsOf(curve, 9)[0], .3, 1e-12);
  EXPECT_NEAR(targetsOf(curve, 9)[1], .1, 1e-12);
  EXPECT_NEAR(targetsOf(curve, 9)[2], .03, 1e-12);
  EXPECT_NEAR(targetsOf(curve, 1).at(0), .03, 1e-12);
  EXPECT_TRUE(targetsOf({}, 4).empty());
}

}  // namespace
}  // namespace brume
