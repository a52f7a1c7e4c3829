// SPDX-License-Identifier: Apache-2.0
#include "transport/light_grid.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "core/log.h"
#include "core/rng.h"
#include "support/render_text.h"

namespace brume {
namespace {

const std::string kFloor =
    "Shape \"trianglemesh\" \"integer indices\" [0 1 2 2 3 0]\n"
    "  \"point P\" [-10 -10 0  10 -10 0  10 10 0  -10 10 0]\n";

struct Lit {
  Log log{[] {
    Log::Options options;
    options.capture = true;
    return options;
  }()};
  std::unique_ptr<RenderJob> job;
  explicit Lit(const std::string& lights) {
    job = makeJob("WorldBegin\n" + lights + kFloor + "WorldEnd\n", {}, log);
  }
};

TEST(LightGrid, NoLight) {
  const Lit lit("LightSource \"point\" \"color I\" [0 0 0]\n");
  const LightGrid grid(lit.job->scene());
  EXPECT_TRUE(grid.lights().empty());
  EXPECT_FALSE(grid.choose(Vec3(0), 0.5f).has_value());
}

TEST(LightGrid, OneLightIsAlwaysChosen) {
  const Lit lit(
      "LightSource \"point\" \"color I\" [1 1 1] LightSource \"point\" \"color I\" [0 0 0]\n");
  const LightGrid grid(lit.job->scene());
  ASSERT_EQ(grid.lights().size(), 1u);
  EXPECT_FALSE(grid.hasHittableLights());
  const auto choice = grid.choose(Vec3(3, 1, 0), 0.99f);
  ASSERT_TRUE(choice.has_value());
  EXPECT_EQ(choice->probability, 1.f);
  // A black light is never sampled.
  EXPECT_EQ(grid.probability(Vec3(0), lit.job->scene().lights()[1].get()), 0.f);
}

TEST(LightGrid, ProbabilitiesAreThoseOfTheChoices) {
  std::string lights = "LightSource \"infinite\" \"color L\" [.1 .1 .1]\n";
  for (int i = 0; i < 9; ++i)
    lights += fmt::format("LightSource \"point\" \"color I\" [1 1 1] \"point from\" [{} {} 1]\n",
                          i % 3 * 8 - 8, i / 3 * 8 - 8);
  const Lit lit(lights);
  const LightGrid grid(lit.job->scene());
  ASSERT_EQ(grid.lights().size(), 10u);
  EXPECT_TRUE(grid.hasHittableLights());
  Rng rng(3);
  for (int k = 0; k < 50; ++k) {
    const Vec3 p(rng.uniform() * 24 - 12, rng.uniform() * 24 - 12, rng.uniform() - 0.5f);
    double sum = 0;
    for (const Light* light : grid.lights()) sum += grid.probability(p, light);
    EXPECT_NEAR(sum, 1.0, 1e-5);
    // Equally spaced u fall on each light as often as its probability says, to one step at each
    // end.
    std::map<const Light*, int> counts;
    const int n = 2000;
    for (int i = 0; i < n; ++i) {
      const auto choice = grid.choose(p, (static_cast<float>(i) + 0.5f) / n);
      ASSERT_TRUE(choice.has_value());
      EXPECT_EQ(choice->probability, grid.probability(p, choice->light));
      ++counts[choice->light];
    }
    for (const Light* light : grid.lights())
      EXPECT_NEAR(counts[light], n * grid.probability(p, light), 2);
  }
}

TEST(LightGrid, NearLightsAreChosenMore) {
  const Lit lit(
      "LightSource \"point\" \"color I\" [1 1 1] \"point from\" [-9 -9 1]\n"
      "LightSource \"point\" \"color I\" [1 1 1] \"point from\" [9 9 1]\n");
  const LightGrid grid(lit.job->scene());
  const float near = grid.probability(Vec3(-8, -8, 0), grid.lights()[0]);
  const float far = grid.probability(Vec3(-8, -8, 0), grid.lights()[1]);
  EXPECT_GT(near, 0.9f);
  EXPECT_GE(far, 0.049f);  // the uniform share keeps it alive
}

}  // namespace
}  // namespace brume
