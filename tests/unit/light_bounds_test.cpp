// SPDX-License-Identifier: Apache-2.0
// Bounds of lights against what the lights do at random points.
#include "core/light_bounds.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/log.h"
#include "core/rng.h"
#include "core/sampling.h"
#include "support/render_text.h"
#include "support/volumes.h"

namespace brume {
namespace {

double angle(const Vec3& a, const Vec3& b) {
  return 2 * std::atan2(double{length(a - b)}, double{length(a + b)});
}
double halfAngle(const DirectionCone& cone) { return std::acos(double{cone.cosine}); }

TEST(DirectionCone, UnionHoldsBothAndIsTight) {
  Rng rng(1);
  for (int i = 0; i < 2000; ++i) {
    const DirectionCone a{test::randomDirection(rng), 1 - sqr(rng.uniform())};
    const DirectionCone b{test::randomDirection(rng), 1 - 2 * sqr(rng.uniform())};
    const DirectionCone both = unionOf(a, b);
    for (const DirectionCone& part : {a, b})
      EXPECT_LE(std::min(M_PI, angle(both.axis, part.axis) + halfAngle(part)),
                halfAngle(both) + 1e-5)
          << "case " << i;
    // The smallest cone around two has half the angle that they span together, or is one of them.
    const double spanned = 0.5 * (angle(a.axis, b.axis) + halfAngle(a) + halfAngle(b));
    const double smallest = std::max({spanned, halfAngle(a), halfAngle(b)});
    EXPECT_LE(halfAngle(both), std::min(M_PI, smallest) + 1e-3) << "case " << i;
  }
}

TEST(DirectionCone, SpecialCases) {
  const auto z = DirectionCone::around(Vec3(0, 0, 1));
  EXPECT_EQ(unionOf(z, z).cosine, 1);
  EXPECT_TRUE(unionOf(z, DirectionCone::around(Vec3(0, 0, -1))).isEverything());
  EXPECT_TRUE(unionOf(z, {}).isEverything());
}

/// Each light with a bound, shining on points all around it.
TEST(LightBounds, HoldWhatLightsSend) {
  for (const std::string light :
       {"LightSource \"point\" \"point from\" [1 2 3] \"color I\" [1 2 3]",
        "LightSource \"spot\" \"point from\" [1 2 3] \"point to\" [3 1 2] \"color I\" [1 2 3]",
        "Scale 1 2 3 LightSource \"spot\" \"point from\" [1 2 3] \"point to\" [3 1 2]",
        "Rotate 30 1 2 3 LightSource \"projection\" \"float fov\" 70",
        "LightSource \"goniometric\" \"color I\" [1 2 3]",
        "AreaLightSource \"area\" Shape \"sphere\" \"float radius\" 2",
        "Rotate 50 1 2 3 AreaLightSource \"area\" Shape \"disk\" \"float radius\" 2",
        "ReverseOrientation AreaLightSource \"area\" Shape \"disk\" \"float radius\" 2",
        "AreaLightSource \"area\" \"color L\" [3 2 1] Shape \"trianglemesh\" \"integer indices\" "
        "[0 1 2 0 2 3] \"point P\" [0 0 0 1 0 0 1 1 .3 0 1 0]",
        "Scale -1 1 1 AreaLightSource \"area\" Shape \"trianglemesh\" \"integer indices\" [0 1 2] "
        "\"point P\" [0 0 0 1 0 0 1 1 .3]"}) {
    Log log({Verbosity::Normal, false, true});
    const auto job = makeJob("WorldBegin\n" + light + "\nWorldEnd\n", {}, log);
    const Light& shining = *job->scene().lights().front();
    const auto bounds = shining.bounds();
    ASSERT_TRUE(bounds) << light;
    Rng rng(2);
    int lit = 0;
    double brightest = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3 p = 6.f * test::randomDirection(rng) * rng.uniform() + Vec3(1, 2, 3);
      const auto sample = shining.sampleLi(p, rng.uniform2());
      if (!sample || sample->L.isBlack()) continue;
      ++lit;
      const Vec3 q = p + sample->wi * sample->distance;
      const Vec3 slack(1e-5f * (length(p) + length(q) + 1));
      EXPECT_TRUE((Bounds3{bounds->box.lo - slack, bounds->box.hi + slack}.contains(q))) << light;
      const double toAxes = angle(-sample->wi, bounds->axes.axis);
      EXPECT_LE(toAxes, halfAngle(bounds->axes) + std::acos(double{bounds->cosEmission}) + 1e-3)
          << light;
      if (shining.isDelta()) {
        const double intensity = double{lightWeight(sample->L)} * sqr(double{sample->distance});
        EXPECT_LE(intensity, bounds->intensity * 1.0001) << light;
        brightest = std::max(brightest, intensity);
      }
    }
    EXPECT_GT(lit, 100) << light;
    if (shining.isDelta()) {
      EXPECT_GT(brightest, 0.9 * bounds->intensity) << light;
    }
  }
}

TEST(LightBounds, FlatLightsShineToOneSide) {
  const auto axes = [](const std::string& shape) {
    Log log({Verbosity::Normal, false, true});
    const auto job =
        makeJob("WorldBegin AreaLightSource \"area\" " + shape + " WorldEnd\n", {}, log);
    return job->scene().lights().front()->bounds()->axes;
  };
  EXPECT_NEAR(axes("Shape \"disk\"").cosine, 1, 1e-6);
  EXPECT_NEAR(axes("Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] "
                   "\"point P\" [0 0 0 1 0 0 1 1 0 0 1 0]")
                  .axis.z,
              1, 1e-6);
  EXPECT_TRUE(axes("Shape \"sphere\"").isEverything());
}

TEST(LightBounds, SumsForgetNothing) {
  LightBounds sum;
  sum += pointBounds(Vec3(1, 2, 3), 0);  // black: takes no room
  EXPECT_EQ(sum.intensity, 0);
  sum += pointBounds(Vec3(1, 2, 3), 2);
  sum += pointBounds(Vec3(-1, 5, 3), 3);
  EXPECT_EQ(sum.intensity, 5);
  EXPECT_EQ(sum.box.lo, Vec3(-1, 2, 3));
  EXPECT_EQ(sum.box.hi, Vec3(1, 5, 3));
}

}  // namespace
}  // namespace brume
