// SPDX-License-Identifier: Apache-2.0
#include "transport/light_tree.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "core/log.h"
#include "core/rng.h"
#include "support/render_text.h"
#include "support/volumes.h"

namespace brume {
namespace {

struct Lit {
  Log log{{Verbosity::Normal, false, true}};
  std::unique_ptr<RenderJob> job;
  explicit Lit(const std::string& lights) {
    job = makeJob("WorldBegin\n" + lights +
                      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 2 3 0]\n"
                      "  \"point P\" [-10 -10 0  10 -10 0  10 10 0  -10 10 0]\nWorldEnd\n",
                  {}, log);
  }
};

std::string pointLight(const Vec3& from, float intensity) {
  return fmt::format(
      "LightSource \"point\" \"color I\" [{0} {0} {0}] \"point from\" [{1} {2} {3}]\n", intensity,
      from.x, from.y, from.z);
}

/// Lights of all kinds at random places and of very different strengths.
std::string randomLights(int count, std::uint64_t seed) {
  Rng rng(seed);
  std::string text =
      "LightSource \"infinite\" \"color L\" [.01 .01 .01]\n"
      "LightSource \"distant\" \"color L\" [.1 .1 .1]\n";
  const auto coordinate = [&] { return rng.uniform() * 20 - 10; };
  for (int i = 0; i < count; ++i) {
    const float strength = std::pow(10.f, rng.uniform() * 4 - 2);
    const Vec3 at(coordinate(), coordinate(), coordinate());
    const Vec3 to(coordinate(), coordinate(), coordinate());
    switch (i % 3) {
      case 0:
        text += pointLight(at, strength);
        break;
      case 1:
        text += fmt::format(
            "LightSource \"spot\" \"color I\" [{0} {0} {0}] \"point from\" [{1} {2} "
            "{3}] \"point to\" [{4} {5} {6}] \"float coneangle\" {7}\n",
            strength, at.x, at.y, at.z, to.x, to.y, to.z, 5 + 80 * rng.uniform());
        break;
      default:
        text += fmt::format(
            "AttributeBegin Translate {} {} {} Rotate {} 1 2 3 AreaLightSource "
            "\"area\" \"color L\" [{} 1 1] Shape \"disk\" AttributeEnd\n",
            at.x, at.y, at.z, 360 * rng.uniform(), strength);
    }
  }
  return text;
}

Vec3 randomPoint(Rng& rng) {
  return Vec3(rng.uniform(), rng.uniform(), rng.uniform()) * 24.f - Vec3(12);
}

TEST(LightTree, NoLight) {
  const Lit lit(pointLight(Vec3(0), 0));
  const LightTree tree(lit.job->scene());
  EXPECT_TRUE(tree.isEmpty());
  EXPECT_FALSE(tree.choose(PointReceiver(Vec3(0)), 0.5f).has_value());
}

TEST(LightTree, OneLightIsAlwaysChosen) {
  const Lit lit(pointLight(Vec3(0), 1) + pointLight(Vec3(0), 0));
  const LightTree tree(lit.job->scene());
  ASSERT_EQ(tree.lights().size(), 1u);
  EXPECT_FALSE(tree.hasHittableLights());
  const auto choice = tree.choose(PointReceiver(Vec3(3, 1, 0)), 0.99f);
  ASSERT_TRUE(choice.has_value());
  EXPECT_EQ(choice->probability, 1.f);
  // A black light is never sampled.
  EXPECT_EQ(tree.probability(PointReceiver(Vec3(0)), lit.job->scene().lights()[1].get()), 0.f);
}

/// Evenly spaced u fall on each light as often as its probability says.
template <class Receiver>
void expectProbabilitiesOfChoices(const LightTree& tree, const Receiver& receiver) {
  constexpr int kCount = 4000;
  std::map<const Light*, int> counts;
  int none = 0;
  for (int i = 0; i < kCount; ++i) {
    const auto choice = tree.choose(receiver, (static_cast<float>(i) + 0.5f) / kCount);
    if (!choice) {
      ++none;
      continue;
    }
    EXPECT_FLOAT_EQ(choice->probability, tree.probability(receiver, choice->light));
    ++counts[choice->light];
  }
  double sum = 0;
  for (const Light* light : tree.lights()) {
    const float p = tree.probability(receiver, light);
    sum += double{p};
    EXPECT_GE(p, 0.0999 / double(tree.lights().size()));
    // Two stretches of u lead to a light, its share of the even part and that of the tree: one
    // step more or less at each end.
    EXPECT_NEAR(counts[light], double{p} * kCount, 4.01);
  }
  EXPECT_NEAR(sum + double(none) / kCount, 1.0, 1e-3);
}

TEST(LightTree, ProbabilitiesAreThoseOfTheChoices) {
  for (int count : {1, 2, 7, 60}) {
    const Lit lit(randomLights(count, 5));
    const LightTree tree(lit.job->scene());
    EXPECT_TRUE(tree.hasHittableLights());
    Rng rng(3);
    for (int k = 0; k < 10; ++k) {
      const Vec3 p = randomPoint(rng), d = test::randomDirection(rng);
      expectProbabilitiesOfChoices(tree, PointReceiver(p));
      expectProbabilitiesOfChoices(tree, PointReceiver(p, d));
      expectProbabilitiesOfChoices(tree, RayReceiver(Ray{p, d}, {1, 1 + 20 * rng.uniform()}));
    }
  }
}

TEST(LightTree, LightThatArrivesIsFoundByImportance) {
  // More than the even share: no bound cuts it off.
  const Lit lit(randomLights(300, 6));
  const LightTree tree(lit.job->scene());
  const float even = 0.1f / static_cast<float>(tree.lights().size());
  Rng rng(7);
  int arrivals = 0;
  for (int k = 0; k < 300; ++k) {
    const Vec3 p = randomPoint(rng), d = test::randomDirection(rng);
    const Ray ray{p, d};
    const Interval range{0, 0.1f + 20 * rng.uniform()};
    const RayReceiver stretch(ray, range);
    const float t = range.t1 * rng.uniform();
    for (const Light* light : tree.lights()) {
      if (light->sampleLi(p, rng.uniform2())) {
        EXPECT_GT(tree.probability(PointReceiver(p), light), even);
        EXPECT_GT(tree.probability(PointReceiver(p, d), light), even);
        ++arrivals;
      }
      if (light->sampleLi(ray(t), rng.uniform2())) {
        EXPECT_GT(tree.probability(stretch, light), even);
      }
    }
  }
  EXPECT_GT(arrivals, 300 * 100);
}

TEST(LightTree, FollowsWhatArrives) {
  // Shares of isotropic points are close to those of their irradiance, at a point and along a ray.
  Rng rng(8);
  std::string text;
  std::vector<Vec3> places;
  std::vector<float> strengths;
  for (int i = 0; i < 500; ++i) {
    places.push_back(randomPoint(rng));
    strengths.push_back(std::pow(10.f, rng.uniform() * 2));
    text += pointLight(places.back(), strengths.back());
  }
  const Lit lit(text);
  const LightTree tree(lit.job->scene());
  double variance = 0, powerVariance = 0;
  constexpr int kPoints = 200;
  for (int k = 0; k < kPoints; ++k) {
    const Vec3 p = randomPoint(rng);
    double total = 0, power = 0, squares = 0, powerSquares = 0;
    for (float s : strengths) power += double{s};
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Vec3d d = Vec3d(tree.lights()[i]->position().value()) - Vec3d(p);
      const double E = double{strengths[i]} / dot(d, d);
      total += E;
      squares += E * E / double{tree.probability(PointReceiver(p), tree.lights()[i])};
      powerSquares += E * E * power / double{strengths[i]};
    }
    variance += squares / (total * total) - 1;
    powerVariance += powerSquares / (total * total) - 1;
  }
  // Relative variance of the sum of all lights from one of them; by power alone it is far larger.
  EXPECT_LT(variance / kPoints, 0.5);
  EXPECT_GT(powerVariance / kPoints, 20 * variance / kPoints);
}

TEST(LightTree, LightsAtOnePlaceAreTakenApart) {
  std::string text;
  for (int i = 0; i < 40; ++i) text += pointLight(Vec3(1, 2, 3), 1 + static_cast<float>(i));
  const Lit lit(text);
  const LightTree tree(lit.job->scene());
  double power = 0;
  for (int i = 0; i < 40; ++i) power += 1 + i;
  for (int i = 0; i < 40; ++i)
    EXPECT_NEAR(tree.probability(PointReceiver(Vec3(0)), tree.lights()[i]),
                0.9 * (1 + i) / power + 0.1 / 40, 1e-6);
  // At the lights themselves nothing overflows.
  expectProbabilitiesOfChoices(tree, PointReceiver(Vec3(1, 2, 3)));
  expectProbabilitiesOfChoices(tree, RayReceiver(Ray{Vec3(1, 2, 0), Vec3(0, 0, 1)}, {0, 9}));
}

TEST(LightTree, ExtremesOfScaleAndStrengthKeepTheirShares) {
  for (float scale : {1e-6f, 1e6f})
    for (float strength : {1e-20f, 1e20f}) {
      const Lit lit(pointLight(Vec3(scale, 0, 0), strength) +
                    pointLight(Vec3(0, 2 * scale, 0), 4 * strength));
      const LightTree tree(lit.job->scene());
      EXPECT_NEAR(tree.probability(PointReceiver(Vec3(0)), tree.lights()[0]), 0.5, 1e-4);
    }
}

}  // namespace
}  // namespace brume
