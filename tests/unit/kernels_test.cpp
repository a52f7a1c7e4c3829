// SPDX-License-Identifier: Apache-2.0
#include "transport/kernels.h"

#include <gtest/gtest.h>

#include <algorithm>

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

TEST(Kernels, KnowWhatAPlaneCutsOff) {
  // By slices: at the height z the ball's section is a disc of radius^2 r^2 - z^2.
  const BallKernel ball(1);
  for (const double u : {-1.5, -1., -0.7, -0.1, 0., 0.4, 0.95, 1., 7.}) {
    const double sum = integrate(std::clamp(u, -1., 1.) + 1, [&](double h) {
      const double z = h - 1;
      return integrate(std::sqrt(std::max(0., 1 - z * z)), [&](double d) {
        return 2 * kPiD * d * double{ball(static_cast<float>(d * d + z * z))};
      });
    });
    EXPECT_NEAR(sum, double{ballKernelBefore(static_cast<float>(u))}, kTolerance) << u;
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
