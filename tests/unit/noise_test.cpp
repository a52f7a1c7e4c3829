// SPDX-License-Identifier: Apache-2.0
#include "core/noise.h"

#include <gtest/gtest.h>

namespace brume {
namespace {

/// Points that fill a cube of 40 cells evenly enough for averages.
template <class F>
void forPoints(int count, const F& f) {
  for (int i = 0; i < count; ++i) {
    const auto fraction = [&](float a) {
      return 40.f * std::fmod(a * static_cast<float>(i), 1.f) - 20.f;
    };
    f(Vec3(fraction(.8191725f), fraction(.6710436f), fraction(.5497005f)));
  }
}

TEST(Noise, IsBoundedWithMeanZero) {
  double sum = 0, sumAbs = 0;
  float largest = 0;
  constexpr int kCount = 20000;
  forPoints(kCount, [&](const Vec3& p) {
    const float n = noise(p);
    sum += n;
    sumAbs += std::abs(n);
    largest = std::max(largest, std::abs(n));
  });
  EXPECT_LT(largest, 1.f);
  EXPECT_GT(largest, .7f);
  EXPECT_NEAR(sum / kCount, 0, .01);      // standard deviation 0.27 / sqrt(20000) = 0.002
  EXPECT_NEAR(sumAbs / kCount, .2, .03);  // the 0.2 that turbulence stands on
}

TEST(Noise, ClosedForms) {
  // Zero on the lattice, of period 256.
  EXPECT_EQ(noise({3, -7, 11}), 0);
  EXPECT_EQ(noise({.25f, .5f, .75f}), noise({256.25f, -255.5f, .75f}));
  // By hand: permutation 151, 160, 137, ... gives the gradients of the eight corners of cell
  // (0,0,0). At (t, 0, 0) only the corners (0,0,0) and (1,0,0) count, with gradients (1,0,1)-like
  // directions.
  const auto slope = [](float x) {
    return (noise({x + 1e-3f, 0, 0}) - noise({x - 1e-3f, 0, 0})) / 2e-3f;
  };
  for (const float x : {0.f, 1.f, 2.f, 17.f}) {
    // On a lattice point the derivative is the x component of the gradient: -1, 0 or 1.
    const float s = slope(x);
    EXPECT_NEAR(s, std::round(s), 1e-3f);
    EXPECT_LE(std::abs(s), 1.01f);
  }
}

TEST(Noise, IsSmoothAcrossCells) {
  // Value and slope from both sides of a cell's face.
  const float h = 1e-3f;
  for (const float x : {1.f, 5.f}) {
    const auto f = [&](float d) { return noise({x + d, .3f, .6f}); };
    EXPECT_NEAR(f(-1e-6f), f(1e-6f), 1e-5f);
    EXPECT_NEAR((f(h) - f(0)) / h, (f(0) - f(-h)) / h, 1e-2f);
  }
}

TEST(Noise, AnyFloatIsSafe) {
  for (const float x : {1e9f, -3e9f, 1e30f, -kInfinity, kInfinity, std::nanf("")})
    EXPECT_LE(std::abs(noise({x, .3f, -x})), 1.f) << x;
}

TEST(Fbm, SumsOctavesAndFades) {
  const Vec3 p(.3f, .7f, .2f), tiny(0.f);
  EXPECT_EQ(fbm(p, tiny, tiny, .5f, 0), 0);
  EXPECT_EQ(fbm(p, tiny, tiny, .5f, 1), noise(p));
  EXPECT_FLOAT_EQ(fbm(p, tiny, tiny, .5f, 3),
                  noise(p) + .5f * noise(1.99f * p) + .25f * noise(1.99f * 1.99f * p));
  EXPECT_FLOAT_EQ(turbulence(p, tiny, tiny, .5f, 2),
                  std::abs(noise(p)) + .5f * std::abs(noise(1.99f * p)));
  // A footprint of 2^-1.5 admits 1 + 1.5 octaves: one and, half faded, another, of eight.
  const Vec3 step(std::exp2(-1.5f), 0, 0);
  EXPECT_NEAR(fbm(p, step, tiny, .5f, 8),
              noise(p) + .5f * noise(1.99f * p) + .5f * .25f * noise(1.99f * 1.99f * p), 1e-5f);
  EXPECT_NEAR(turbulence(p, tiny, step, .5f, 8),
              std::abs(noise(p)) + .5f * std::abs(noise(1.99f * p)) +
                  .5f * .25f * std::abs(noise(1.99f * 1.99f * p)) + .2f * 5.5f,
              1e-5f);
  EXPECT_TRUE(std::isfinite(fbm(p, Vec3(1e30f), tiny, .5f, 8)));
  EXPECT_TRUE(std::isfinite(turbulence(p, Vec3(kInfinity), tiny, .5f, 8)));
}

}  // namespace
}  // namespace brume
