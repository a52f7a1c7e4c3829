// SPDX-License-Identifier: Apache-2.0
#include "transport/kernels.h"

#include <gtest/gtest.h>

namespace brume {
namespace {

/// Int_0^r f(d) dd by the midpoint rule with 2000 points: exact to 1e-6 for these polynomials.
template <class F>
double integrate(double r, F&& f) {
  constexpr int kPoints = 2000;
  double sum = 0;
  for (int i = 0; i < kPoints; ++i) sum += f((i + 0.5) * r / kPoints);
  return sum * r / kPoints;
}

constexpr double kPiD = 3.14159265358979323846;
constexpr float kRadii[] = {1e-3f, 0.7f, 1.f, 4e3f};
// Kernel values are floats: a few roundings each.
constexpr double kTolerance = 2e-6;

TEST(Kernels, IntegrateToOne) {
  for (const float r : kRadii) {
    const DiscKernel disc(r * r);
    const BallKernel ball(r * r);
    const auto discShell = [&](double d) {
      return 2 * kPiD * d * double{disc(static_cast<float>(d * d))};
    };
    const auto ballShell = [&](double d) {
      return 4 * kPiD * d * d * double{ball(static_cast<float>(d * d))};
    };
    EXPECT_NEAR(integrate(double{r}, discShell), 1, kTolerance) << r;
    EXPECT_NEAR(integrate(double{r}, ballShell), 1, kTolerance) << r;
  }
}

TEST(Kernels, HaveTheSecondMomentsOfTheirBias) {
  for (const float r : kRadii) {
    const DiscKernel disc(r * r);
    const BallKernel ball(r * r);
    // x_1^2 is on average d^2 / 2 over a circle and d^2 / 3 over a sphere.
    const double ofDisc = integrate(double{r}, [&](double d) {
      return 2 * kPiD * d * double{disc(static_cast<float>(d * d))} * d * d / 2;
    });
    const double ofBall = integrate(double{r}, [&](double d) {
      return 4 * kPiD * d * d * double{ball(static_cast<float>(d * d))} * d * d / 3;
    });
    const double r2 = double{r} * double{r};
    EXPECT_NEAR(ofDisc / (2 * r2), double{kDiscKernelBias}, kTolerance) << r;
    EXPECT_NEAR(ofBall / (2 * r2), double{kBallKernelBias}, kTolerance) << r;
  }
}

TEST(Kernels, AreZeroFromTheRadiusOn) {
  const DiscKernel disc(4);
  const BallKernel ball(4);
  for (const float d2 : {4.f, 4.0001f, 1e30f, kInfinity}) {
    EXPECT_EQ(disc(d2), 0) << d2;
    EXPECT_EQ(ball(d2), 0) << d2;
  }
  EXPECT_GT(disc(3.9f), 0);
  EXPECT_GT(ball(3.9f), 0);
  EXPECT_FLOAT_EQ(disc(0), 3 / (kPi * 4));
  EXPECT_FLOAT_EQ(ball(0), 105 / (32 * kPi * 8));
}

}  // namespace
}  // namespace brume
