// SPDX-License-Identifier: Apache-2.0
// Which segments look at point lights, and where.
#include "transport/segment_lights.h"

#include <gtest/gtest.h>

#include "support/media_scene.h"
#include "support/volumes.h"

namespace brume {
namespace {

constexpr Rgb kEven(1 / 3.f, 1 / 3.f, 1 / 3.f);

/// A cube of side 10 around the origin with a grid of this mean sigma_s, and lights at these
/// points.
Scene fogWithLights(float sigma_s, const std::vector<Vec3>& lights) {
  test::MediumSpec spec;
  spec.sigma_s = Rgb(0.5f * sigma_s, sigma_s, 1.5f * sigma_s);
  spec.p0 = Vec3(-5);
  spec.p1 = Vec3(5);
  Rng rng(3);
  std::vector<std::unique_ptr<Volume>> volumes;
  volumes.push_back(test::makeGrid(spec, 4, 4, 4, test::randomDensities(64, rng)));
  std::vector<std::unique_ptr<Light>> sources;
  for (const Vec3& from : lights) sources.push_back(test::makePointLight({from, Rgb(1)}));
  return test::makeMediaScene(std::move(volumes), std::move(sources));
}

MediumAlongRay along(const Scene& scene, const Ray& ray) {
  const auto range = scene.volume()->intersect(ray);
  return range ? MediumAlongRay(*scene.volume(), ray, *range) : MediumAlongRay();
}

TEST(SegmentLights, LooksWhereFlightsSeldomEnd) {
  const Scene thin = fogWithLights(.02f, {Vec3(0)}), thick = fogWithLights(4, {Vec3(0)});
  const SegmentLights inThin(thin, .1), inThick(thick, .1);
  const auto looks = [](const Scene& scene, const SegmentLights& lights, const Ray& ray,
                        const Vec3& p) { return lights.looksAt(along(scene, ray), kEven, p); };
  const Ray passing{Vec3(-20, 1, 0), Vec3(1, 0, 0)};
  EXPECT_TRUE(looks(thin, inThin, passing, Vec3(0)));
  EXPECT_FALSE(looks(thick, inThick, passing, Vec3(0))) << "ten mean free paths away";
  const Ray beside{Vec3(.05f, -.1f, 0), Vec3(0, 1, 0), .2f};
  EXPECT_TRUE(looks(thick, inThick, beside, Vec3(0))) << "a tenth of a mean free path away";
  // A light far from a medium shines on all of it: as if it were just outside.
  EXPECT_TRUE(looks(thin, inThin, passing, Vec3(1000, 0, 0)));
  EXPECT_FALSE(looks(thick, inThick, passing, Vec3(1000, 0, 0)));
}

TEST(SegmentLights, DensityIsThatOfTheSamples) {
  // Two lights of three are looked at or not from ray to ray; the samples' density is pdf(), and
  // their number that of its integral.
  const std::vector<Vec3> positions = {Vec3(0), Vec3(1, 2, -1), Vec3(6, 0, 0)};
  const Scene scene = fogWithLights(.6f, positions);
  const SegmentLights lights(scene, .1);
  Rng rng(5);
  int looked = 0, blind = 0;
  for (int i = 0; i < 60; ++i) {
    const Vec3 from = Vec3(rng.uniform(), rng.uniform(), rng.uniform()) * 10.f - Vec3(5);
    const MediumAlongRay medium =
        along(scene, Ray{from, test::randomDirection(rng), 1 + 6 * rng.uniform()});
    if (medium.isEmpty()) continue;
    double integral = 0;
    SegmentLights::Chances chances;
    for (const auto& light : scene.lights()) {
      const double a = double{medium.range().t0}, b = double{medium.range().t1};
      integral += test::integrate(
          [&](double t) {
            return double{lights.pdf(medium, kEven, chances, *light, static_cast<float>(t))};
          },
          a, b, 400);
    }
    if (!lights.mayHelp(medium, kEven)) {
      EXPECT_EQ(integral, 0);
      ++blind;
      continue;
    }
    constexpr int kSamples = 2000;
    int found = 0;
    for (int k = 0; k < kSamples; ++k) {
      const auto s = lights.sample(medium, kEven, chances, rng.uniform(), rng.uniform());
      if (!s) continue;
      ++found;
      EXPECT_TRUE(lights.looksAt(medium, kEven, *s->light->position()));
      ASSERT_NEAR(s->pdf, lights.pdf(medium, kEven, chances, *s->light, s->t), 1e-5f * s->pdf);
    }
    looked += found > 0;
    // Four standard errors of a share, and the quadrature's own.
    EXPECT_NEAR(double(found) / kSamples, integral,
                4 * std::sqrt(integral * std::max(0.0, 1 - integral) / kSamples) + 2e-3);
  }
  EXPECT_GT(looked, 10);
}

TEST(SegmentLights, NoLights) {
  const Scene scene = fogWithLights(1, {});
  const SegmentLights lights(scene, .1);
  EXPECT_FALSE(lights.mayHelp(along(scene, Ray{Vec3(0), Vec3(1, 0, 0)}), kEven));
}

}  // namespace
}  // namespace brume
