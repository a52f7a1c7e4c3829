// SPDX-License-Identifier: Apache-2.0
#include "core/filter.h"

#include <gtest/gtest.h>

#include "support/make_plugin.h"

namespace brume {
namespace {

using namespace test;

const char* const kNames[] = {"box", "triangle", "gaussian", "mitchell", "sinc"};

double integralX(const Filter& filter) {
  constexpr int kSteps = 4000;
  const double w = filter.radius().x, h = 2 * w / kSteps;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i)
    sum += filter.weightX(static_cast<float>(-w + (i + 0.5) * h)) * h;
  return sum;
}

TEST(Filter, DefaultsAreThoseOfPbrt) {
  const float widths[] = {0.5f, 2, 2, 2, 4};
  for (int i = 0; i < 5; ++i) {
    const auto filter = make<Filter>(kNames[i], {});
    ASSERT_TRUE(filter) << kNames[i];
    EXPECT_EQ(filter->radius(), Vec2(widths[i]));
  }
}

TEST(Filter, SeparableEvenAndContinuousAtTheBorder) {
  for (const char* name : kNames) {
    const auto filter = make<Filter>(name, {floats("xwidth", {3}), floats("ywidth", {1.5f})});
    EXPECT_EQ(filter->radius(), Vec2(3, 1.5f));
    for (float x = 0; x < 3; x += 0.37f) {
      EXPECT_EQ(filter->weightX(x), filter->weightX(-x)) << name;
      // Half as high as wide: the same profile, up to the tent's and Gaussian's own units.
      if (std::string(name) == "mitchell" || std::string(name) == "sinc") {
        EXPECT_FLOAT_EQ(filter->weightX(x), filter->weightY(x / 2)) << name;
      }
    }
    EXPECT_EQ(filter->weight(1, 0.5f), filter->weightX(1) * filter->weightY(0.5f));
    if (!filter->isConstant()) {
      EXPECT_NEAR(filter->weightX(2.9999f), 0, 2e-4) << name;
    }
  }
}

TEST(Filter, ClosedForms) {
  const auto gaussian = make<Filter>("gaussian", {floats("alpha", {0.5f})});
  EXPECT_FLOAT_EQ(gaussian->weightX(1), std::exp(-0.5f) - std::exp(-2.f));
  const auto triangle = make<Filter>("triangle", {});
  EXPECT_FLOAT_EQ(triangle->weightX(-0.5f), 1.5f);
  const auto sinc = make<Filter>("sinc", {});
  EXPECT_EQ(sinc->weightX(0), 1);
  EXPECT_NEAR(sinc->weightX(4.f / 3), 0, 1e-6);  // sin(3 pi / 3) = 0
  const float t = 0.25f * kPi;
  EXPECT_FLOAT_EQ(sinc->weightX(1), std::sin(t) / t * std::sin(3 * t) / (3 * t));
  // Mitchell: (6 - 2B)/6 in the middle, B/6 at |x| = 1, on both pieces.
  const auto mitchell = make<Filter>("mitchell", {});
  EXPECT_FLOAT_EQ(mitchell->weightX(0), 8.f / 9);
  EXPECT_NEAR(mitchell->weightX(1), 1.f / 18, 1e-7);  // cancellation of terms near 1
  EXPECT_NEAR(mitchell->weightX(1.0001f), 1.f / 18, 1e-4);
  EXPECT_LT(mitchell->weightX(1.5f), 0);
}

TEST(Filter, Integrals) {
  // Midpoint rule with 4000 steps: error below 1e-5 for these smooth profiles.
  EXPECT_NEAR(integralX(*make<Filter>("box", {})), 1, 1e-5);
  EXPECT_NEAR(integralX(*make<Filter>("triangle", {})), 4, 1e-5);
  EXPECT_NEAR(integralX(*make<Filter>("gaussian", {})),
              std::sqrt(M_PI / 2) * std::erf(2 * std::sqrt(2.0)) - 4 * std::exp(-8.0), 1e-5);
  // The cubic integrates to 1 for any B, C on its own support [-2, 2].
  for (float c : {0.f, 0.5f, 1.f})
    EXPECT_NEAR(integralX(*make<Filter>("mitchell", {floats("B", {0.2f}), floats("C", {c})})), 1,
                1e-5);
}

TEST(Filter, EndsOfTheRanges) {
  for (const char* name : kNames) {
    EXPECT_NO_THROW(make<Filter>(name, {floats("xwidth", {1e-6f}), floats("ywidth", {64})}));
    EXPECT_THROW(make<Filter>(name, {floats("xwidth", {0})}), SceneError) << name;
    EXPECT_THROW(make<Filter>(name, {floats("ywidth", {64.1f})}), SceneError) << name;
    const auto narrow = make<Filter>(name, {floats("xwidth", {1e-6f})});
    EXPECT_TRUE(std::isfinite(narrow->weight(5e-7f, 0))) << name;
  }
  EXPECT_THROW(make<Filter>("gaussian", {floats("alpha", {0})}), SceneError);
  EXPECT_THROW(make<Filter>("sinc", {floats("tau", {-1})}), SceneError);
}

}  // namespace
}  // namespace brume
