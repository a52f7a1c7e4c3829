// SPDX-License-Identifier: Apache-2.0
// Directions towards emitting media against their density.
#include "transport/emission_sampling.h"

#include <gtest/gtest.h>

#include "core/sampling.h"
#include "support/media_scene.h"
#include "support/volumes.h"

namespace brume {
namespace {

/// Three emitters of different kinds, two of them overlapping, and a dark medium.
Scene scene() {
  std::vector<std::unique_ptr<Volume>> volumes;
  test::MediumSpec spec;
  spec.Le = Rgb(1, 2, .5f);
  spec.sigma_a = Rgb(.1f);
  spec.volumeToWorld = Transform::rotate(30, Vec3d(1, 2, 3)) * Transform::scale(1, 2, 1);
  volumes.push_back(test::makeHomogeneous(spec));
  Rng rng(1);
  spec.volumeToWorld = Transform::translate(Vec3d(.5, .2, 0));
  volumes.push_back(test::makeGrid(spec, 4, 3, 2, test::randomDensities(24, rng, .3f)));
  spec.volumeToWorld = Transform::translate(Vec3d(-3, 1, 2));
  volumes.push_back(test::makeExponential(spec, 2, 3, Vec3(1, 2, 0)));
  spec.Le = Rgb(0);
  volumes.push_back(test::makeHomogeneous(spec));
  return test::makeMediaScene(std::move(volumes), {});
}

float pdfAlong(const Scene& scene, const EmissionSampler& sampler, const Vec3& p, const Vec3& w) {
  const Ray ray{p, w};
  const auto range = scene.volume()->intersect(ray);
  if (!range) return 0;
  return sampler.pdf(ray, MediumAlongRay(*scene.volume(), ray, *range));
}

const Vec3 kInside(.6f, .5f, .4f), kOutside(3, -1, 2);

TEST(EmissionSampler, DensityIsThatOfTheDirections) {
  // The mean of f(w) over directions drawn, against its integral with the density by uniform ones.
  const Scene media = scene();
  const EmissionSampler sampler(media);
  ASSERT_FALSE(sampler.isEmpty());
  const auto f = [](const Vec3& w, int i) {
    return i == 0 ? 1.0 : i == 1 ? sqr(1.0 + double{w.x}) : std::exp(double{w.y - w.z});
  };
  for (const Vec3& p : {kInside, kOutside}) {
    constexpr int kCount = 40000;
    double drawn[3] = {}, drawn2[3] = {}, uniform[3] = {}, uniform2[3] = {};
    Rng rng(2);
    for (int i = 0; i < kCount; ++i) {
      const auto w = sampler.sample(p, rng.uniform2());
      ASSERT_TRUE(w);
      EXPECT_GT(pdfAlong(media, sampler, p, *w), 0);
      const Vec3 v = sampleUniformSphere(rng.uniform2());
      const double density = double{pdfAlong(media, sampler, p, v)} * 4 * M_PI;
      for (int k = 0; k < 3; ++k) {
        drawn[k] += f(*w, k) / kCount;
        drawn2[k] += sqr(f(*w, k)) / kCount;
        uniform[k] += density * f(v, k) / kCount;
        uniform2[k] += sqr(density * f(v, k)) / kCount;
      }
    }
    for (int k = 0; k < 3; ++k) {
      const double error =
          std::sqrt((drawn2[k] - sqr(drawn[k]) + uniform2[k] - sqr(uniform[k])) / kCount);
      EXPECT_LT(std::abs(drawn[k] - uniform[k]), 4 * error) << k;
      EXPECT_LT(error, 0.06 * drawn[k]);  // uniform directions seldom meet what is far
    }
  }
}

TEST(EmissionSampler, DensityReachesBehindTheEndOfTheRay) {
  const Scene media = scene();
  const EmissionSampler sampler(media);
  Ray ray{kInside, normalize(Vec3(-.2f, .3f, -.1f))};
  const float whole = pdfAlong(media, sampler, ray.o, ray.d);
  for (float end : {1e-3f, .1f, .5f, 5.f}) {
    ray.tMax = end;
    const auto range = media.volume()->intersect(ray);
    ASSERT_TRUE(range);
    EXPECT_NEAR(sampler.pdf(ray, MediumAlongRay(*media.volume(), ray, *range)), whole,
                1e-4 * double{whole});
  }
}

TEST(EmissionSampler, ThickMediaShineByTheirSurface) {
  const auto intensity = [](float sigma_a) {
    test::MediumSpec spec;
    spec.Le = Rgb(sigma_a);
    spec.sigma_a = Rgb(sigma_a);
    std::vector<std::unique_ptr<Volume>> volumes;
    volumes.push_back(test::makeHomogeneous(spec));
    return EmissionSampler(test::makeMediaScene(std::move(volumes), {})).bounds().intensity;
  };
  EXPECT_NEAR(intensity(.01f), .01, 1e-6);  // all of it: the unit cube
  EXPECT_NEAR(intensity(100), 1.5, 1e-5);   // a quarter of its surface, of radiance 1
}

TEST(EmissionSampler, KnowsFromWhereItIsSeldomHit) {
  // Two sparks in a large dark smoke, and a glowing fog as large.
  test::MediumSpec spec;
  spec.Le = Rgb(1);
  std::vector<std::unique_ptr<Volume>> sparks, fog;
  for (const Vec3& at : {Vec3(-5, 0, 0), Vec3(5, 0, 0)}) {
    spec.p0 = at - Vec3(.1f);
    spec.p1 = at + Vec3(.1f);
    sparks.push_back(test::makeHomogeneous(spec));
  }
  spec.p0 = Vec3(-6);
  spec.p1 = Vec3(6);
  fog.push_back(test::makeHomogeneous(spec));
  spec.Le = Rgb(0);
  spec.sigma_s = Rgb(1);
  sparks.push_back(test::makeHomogeneous(spec));
  const Scene withSparks = test::makeMediaScene(std::move(sparks), {}),
              withFog = test::makeMediaScene(std::move(fog), {});
  const EmissionSampler few(withSparks), everywhere(withFog);
  for (const Vec3& p : {Vec3(1, 1, 0), Vec3(0, 3, 2), Vec3(5, 5, 5)}) {
    EXPECT_TRUE(few.isSeldomHit(p));
    EXPECT_FALSE(everywhere.isSeldomHit(p));
  }
  EXPECT_TRUE(everywhere.isSeldomHit(Vec3(0, 40, 0)));
}

TEST(EmissionSampler, NothingEmits) {
  std::vector<std::unique_ptr<Volume>> volumes;
  volumes.push_back(test::makeHomogeneous({}));
  EXPECT_TRUE(EmissionSampler(test::makeMediaScene(std::move(volumes), {})).isEmpty());
  EXPECT_TRUE(EmissionSampler(test::makeMediaScene({}, {})).isEmpty());
}

}  // namespace
}  // namespace brume
