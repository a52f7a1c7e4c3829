// SPDX-License-Identifier: Apache-2.0
#include "transport/towards_lights.h"

#include <gtest/gtest.h>

#include "core/sampling.h"
#include "support/media_scene.h"
#include "support/volumes.h"

namespace brume {
namespace {

/// A scattering unit cube with `inside` lights in it and one far away.
Scene scene(int inside) {
  std::vector<std::unique_ptr<Volume>> volumes;
  test::MediumSpec spec;
  spec.sigma_s = Rgb(1);
  volumes.push_back(test::makeHomogeneous(spec));
  std::vector<std::unique_ptr<Light>> lights;
  Rng rng(1);
  for (int i = 0; i < inside; ++i)
    lights.push_back(test::makePointLight(
        {Vec3(rng.uniform(), rng.uniform(), rng.uniform()), Rgb(1 + rng.uniform())}));
  lights.push_back(test::makePointLight({Vec3(3, 4, 5), Rgb(1)}));
  lights.push_back(test::makeDistantLight(Vec3(0, 0, 1), Rgb(1)));
  return test::makeMediaScene(std::move(volumes), std::move(lights));
}

TEST(TowardsLights, OnlyPointsInMediaCount) {
  EXPECT_TRUE(TowardsLights(scene(0)).isEmpty());
  EXPECT_FALSE(TowardsLights(scene(1)).isEmpty());
  const auto none = TowardsLights(scene(0)).from(Vec3(0), .5f);
  EXPECT_EQ(none.share(), 0.f);
  EXPECT_EQ(none.mixed(Vec3(0, 0, 1), .25f), .25f);
}

TEST(TowardsLights, DensityIsThatOfTheDirections) {
  for (int lights : {1, 3, 20}) {
    const TowardsLights towards(scene(lights));
    const auto directions = towards.from(Vec3(.2f, .3f, 1.5f), .3f);
    // 1 / pdf over directions drawn is the whole sphere; a product with the density tests its
    // shape.
    constexpr int kCount = 20000;
    double solidAngle = 0, square = 0, forward = 0, forwardUniform = 0;
    Rng rng(2);
    for (int i = 0; i < kCount; ++i) {
      const Vec3 w = directions.sample(rng.uniform2());
      EXPECT_NEAR(length(w), 1, 1e-6);
      const double inverse = 1 / double{directions.pdf(w)};
      solidAngle += inverse / kCount;
      square += inverse * inverse / kCount;
      forward += (w.z < 0) / double{kCount};
      const Vec3 v = sampleUniformSphere(rng.uniform2());
      // Bounded: the density near the light is left to the other sum.
      if (v.z < 0) forwardUniform += 4 * M_PI * std::min(50.0, double{directions.pdf(v)}) / kCount;
    }
    const double error = std::sqrt((square - sqr(solidAngle)) / kCount);
    EXPECT_LT(std::abs(solidAngle - 4 * M_PI), 4 * error) << lights;
    EXPECT_NEAR(forward, forwardUniform, 0.05) << lights;  // five standard errors
  }
}

TEST(TowardsLights, MixtureStaysAboveBoth) {
  const TowardsLights towards(scene(2));
  const auto directions = towards.from(Vec3(.2f, .3f, 1.5f), .3f);
  Rng rng(3);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 w = directions.sample(rng.uniform2());
    const float mixed = directions.mixed(w, kInv4Pi);
    EXPECT_GE(mixed, (1 - directions.share()) * kInv4Pi);
    EXPECT_GE(mixed, directions.share() * directions.pdf(w));
  }
}

TEST(TowardsLights, AtALightItself) {
  const Scene media = scene(1);
  const Vec3 at = *media.lights().front()->position();
  EXPECT_TRUE(TowardsLights(media).from(at, .5f).isEmpty());
}

}  // namespace
}  // namespace brume
