// SPDX-License-Identifier: Apache-2.0
#include "transport/blur_monitor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/film.h"
#include "core/rng.h"
#include "support/render_text.h"
#include "transport/radius_schedule.h"

namespace brume {
namespace {

constexpr Bounds2i kImage{{0, 0}, {40, 24}};

/// Passes whose pixels are `light` + `blur` s, s the squared radius over the first, with noise that
/// is `shared` by all pixels and noise that is not; their variances in a pass.
struct Passes {
  double light = 1, blur = 0, shared = 0, own = 0;
  double alpha = 2. / 3;

  BlurMonitor run(int count, std::uint64_t seed) const {
    BlurMonitor monitor(kImage);
    Rng rng(seed);
    const auto noise = [&](double variance) {
      return std::sqrt(12 * variance) * (double{rng.uniform()} - 0.5);
    };
    RadiusSchedule schedule(1, alpha);
    for (int j = 0; j < count; ++j) {
      const double common = noise(shared);
      std::vector<ProbeLight> probes(monitor.probeCount());
      for (ProbeLight& probe : probes) {
        const Rgb L(static_cast<float>(light + blur * schedule.radius2() + common + noise(own)));
        probe = {{L, Rgb(0.25f)}, L + Rgb(0.25f)};
      }
      monitor.addPass(probes, {schedule.radius2(), 0});
      schedule.advance();
    }
    return monitor;
  }
  /// Squared, of the mean of `count` passes, relative to the brightness.
  double squaredBlur(int count) const {
    RadiusSchedule schedule(1, alpha);
    double sum = 0;
    for (int j = 0; j < count; ++j, schedule.advance()) sum += schedule.radius2() / count;
    return sqr(blur * sum) / ((1 + kDarkShare) * sqr(light + 0.25 + blur * sum));
  }
};

TEST(BlurMonitor, TellsTheBlurOfTheMean) {
  const Passes passes{.light = 1, .blur = 0.2, .shared = 0.001, .own = 0.04};
  for (int count : {64, 300, 2000}) {
    const auto found = passes.run(count, 3).estimate(BlurMonitor::Beams);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->blur2, passes.squaredBlur(count), 4 * found->blur2Error) << count;
    EXPECT_LT(found->blur2Error, 0.3 * passes.squaredBlur(count)) << count;
    EXPECT_TRUE(found->standsOut()) << count;
  }
}

TEST(BlurMonitor, IsExactWithoutNoise) {
  const Passes passes{.light = 0.5, .blur = 3};
  const auto found = passes.run(64, 1).estimate(BlurMonitor::Beams);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->blur2 / passes.squaredBlur(64), 1, 1e-4);
}

/// Noise that a pass's pixels share looks like blur in each of them; the groups' disagreement must
/// show that it is none.
TEST(BlurMonitor, DoesNotTakeNoiseForBlur) {
  for (const Passes& passes :
       {Passes{.shared = 0.04}, Passes{.own = 0.04}, Passes{.shared = 0.02, .own = 0.02}}) {
    constexpr int kRuns = 200;
    double sum = 0, squares = 0, told = 0;
    int standsOut = 0, isSure = 0;
    for (int run = 0; run < kRuns; ++run) {
      const auto found =
          passes.run(100, 10 + static_cast<std::uint64_t>(run)).estimate(BlurMonitor::Beams);
      ASSERT_TRUE(found);
      sum += found->blur2 / kRuns;
      squares += sqr(found->blur2) / kRuns;
      told += sqr(found->blur2Error) / kRuns;
      standsOut += found->standsOut();
      isSure += found->standsOut(5);
    }
    EXPECT_LT(std::abs(sum), 4 * std::sqrt(squares / kRuns));
    EXPECT_NEAR(std::sqrt(told / squares), 1, 0.3);
    EXPECT_LE(standsOut, kRuns / 14);
    EXPECT_LE(isSure, 3);
  }
}

TEST(BlurMonitor, ShrinksRadiiThatBlurBeyondDoubtOnly) {
  using Estimate = BlurMonitor::Estimate;
  // x^5 = V / (8 B).
  EXPECT_NEAR(
      (Estimate{.blur2 = 4, .blur2Error = 0.5, .variance = 32 * std::pow(0.7, 5)}.radiusFactor()),
      0.7, 1e-6);
  EXPECT_EQ((Estimate{.blur2 = 4, .blur2Error = 1, .variance = 1}.radiusFactor()), 1);
  EXPECT_EQ((Estimate{.blur2 = 4, .blur2Error = 0.1, .variance = 30}.radiusFactor()), 1);
  EXPECT_EQ((Estimate{.blur2 = 4, .blur2Error = 0.1, .variance = 0}.radiusFactor()), 0.5);
  EXPECT_EQ((Estimate{.blur2 = -4, .blur2Error = 0.1, .variance = 1}.radiusFactor()), 1);
}

TEST(BlurMonitor, TellsTheVarianceOfTheMean) {
  const Passes passes{.shared = 0.03, .own = 0.01};
  double sum = 0;
  constexpr int kRuns = 100;
  for (int run = 0; run < kRuns; ++run)
    sum += passes.run(96, 900 + static_cast<std::uint64_t>(run))
               .estimate(BlurMonitor::Beams)
               ->variance /
           kRuns;
  const double expected = 0.04 / 96 / ((1 + kDarkShare) * sqr(1.25));
  EXPECT_NEAR(sum / expected, 1, 4 * std::sqrt(2. / 7 / kRuns));
}

TEST(BlurMonitor, SaysNothingWithoutPassesOrWhereTheRadiusStays) {
  EXPECT_FALSE((Passes{.own = 0.1}.run(20, 1).estimate(BlurMonitor::Beams)));
  // Two runs of passes for each group: one has hardly any change of the radius.
  EXPECT_FALSE((Passes{.own = 0.1}.run(63, 1).estimate(BlurMonitor::Beams)));
  EXPECT_TRUE((Passes{.own = 0.1}.run(64, 1).estimate(BlurMonitor::Beams)));
  EXPECT_FALSE((Passes{.own = 0.1, .alpha = 1}.run(100, 1).estimate(BlurMonitor::Beams)));
  EXPECT_FALSE((Passes{.own = 0.1}.run(100, 1).estimate(BlurMonitor::Surfaces)));
  EXPECT_TRUE((Passes{.own = 0.1}.run(100, 1).estimate(BlurMonitor::Beams)));
}

TEST(BlurMonitor, EveryProbeLooksThroughAPixelOfItsOwn) {
  for (const Bounds2i& image : {Bounds2i{{0, 0}, {1, 1}}, Bounds2i{{-2, 5}, {38, 11}},
                                Bounds2i{{3, 3}, {703, 403}}, Bounds2i{{0, 0}, {33, 32}}}) {
    const BlurMonitor monitor(image);
    std::vector<int> seen(monitor.probeCount());
    for (int y = image.lo.y; y < image.hi.y; ++y)
      for (int x = image.lo.x; x < image.hi.x; ++x)
        if (const auto probe = monitor.probeOf({x, y})) ++seen.at(*probe);
    for (int count : seen) EXPECT_EQ(count, 1);
    EXPECT_EQ(seen.size(),
              static_cast<std::size_t>(std::min(image.width(), 32) * std::min(image.height(), 32)));
  }
}

}  // namespace
}  // namespace brume
