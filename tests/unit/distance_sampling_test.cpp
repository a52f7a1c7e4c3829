// SPDX-License-Identifier: Apache-2.0
#include "transport/distance_sampling.h"

#include <gtest/gtest.h>

#include "support/volumes.h"

namespace brume {
namespace {

struct EquiangularCase {
  Vec3 light;
  Interval range;
};

std::vector<EquiangularCase> equiangularCases() {
  return {{{0, 1, 2}, {0, 5}},        {{0, 1e-3f, 2}, {0, 5}},    {{0, 0, 2}, {0, 5}},
          {{0, 0, 2}, {2, 5}},        {{0, 0, 7}, {2, 5}},        {{3, 0, -4}, {0, 5}},
          {{1e6f, 0, 0}, {0, 5}},     {{1e6f, 0, -1e6f}, {1, 2}}, {{0, 1e-6f, 1e-6f}, {0, 2e-6f}},
          {{0, 1e-9f, 3}, {0, 1e6f}}, {{0, 2, 1e3f}, {999, 1001}}};
}

TEST(Equiangular, DensityIntegratesToOneAndIsThatOfTheSamples) {
  for (const EquiangularCase& c : equiangularCases()) {
    const Ray ray{{0, 0, 0}, {0, 0, 1}};
    const EquiangularSampler sampler(ray, c.range, c.light);
    // Between the distances of u and u + 1/n lies 1/n of the density; in the first and last of
    // these steps the density may span orders of magnitude, so there the closed form must do.
    constexpr int n = 256;
    float previous = sampler.sample(1.f / n).t;
    for (int i = 2; i < n; ++i) {
      const DistanceSample s = sampler.sample(float(i) / n);
      ASSERT_GE(s.t, previous);
      ASSERT_LE(s.t, c.range.t1);
      ASSERT_TRUE(s.pdf > 0 && std::isfinite(s.pdf));
      const double mass = test::integrate([&](double t) { return double{sampler.pdf(float(t))}; },
                                          previous, s.t, 4);
      previous = s.t;
      // t is a float: 6e-8 of the distance from the origin at both ends, times the density.
      EXPECT_NEAR(mass, 1.0 / n, 2e-6 + 1.5e-7 * double{s.t} * double{s.pdf} * 2);
    }
    EXPECT_NEAR(sampler.angleTo(c.range.t1), sampler.angle(), 1e-12);
    EXPECT_NEAR(sampler.at(sampler.angle()) / double{c.range.t1}, 1, 1e-6);
    for (const float u : {.1f, .5f, .9f})
      EXPECT_NEAR(sampler.angleTo(sampler.at(double{u} * sampler.angle())) / sampler.angle(), u,
                  1e-6);
    EXPECT_EQ(sampler.pdf(c.range.t1 * 1.01f + 1), 0);
  }
}

TEST(Equiangular, WeightOfInverseSquareFalloffIsConstant) {
  const Ray ray{{0, 0, 0}, {0, 0, 1}};
  const Vec3 light(.3f, .1f, 2);
  const EquiangularSampler sampler(ray, {0, 5}, light);
  for (int i = 0; i < 100; ++i) {
    const DistanceSample s = sampler.sample(float(i) / 100);
    const float falloff = 1 / lengthSquared(ray(s.t) - light);
    EXPECT_NEAR(falloff / s.pdf, sampler.integral(), 1e-4f * sampler.integral());
  }
}

std::vector<std::unique_ptr<Volume>> media(float scale) {
  Rng rng(3);
  test::MediumSpec grey{.sigma_a = Rgb(.5f * scale), .sigma_s = Rgb(scale)};
  test::MediumSpec chromatic{.sigma_a = Rgb(.01f, .1f, 20.f) * scale,
                             .sigma_s = Rgb(3.f, .3f, .01f) * scale};
  test::MediumSpec red{.sigma_a = Rgb(0, 1, 1) * scale, .sigma_s = Rgb(1, 0, 0) * scale};
  std::vector<std::unique_ptr<Volume>> all;
  for (const test::MediumSpec& spec : {grey, chromatic, red}) {
    all.push_back(test::makeHomogeneous(spec));
    all.push_back(test::makeExponential(spec, 2.f, 3.f));
    all.push_back(test::makeGrid(spec, 5, 3, 8, test::randomDensities(120, rng, .3f)));
  }
  return all;
}

Ray rayThroughBox() { return {{-.4f, .25f, .3f}, normalize(Vec3(1, .2f, .3f))}; }

TEST(TransmittanceSampling, DensityIntegratesToOneInEveryPartOfTheRay) {
  const Ray ray = rayThroughBox();
  for (const float scale : {1e-6f, 1e-2f, 1.f, 50.f})
    for (const auto& volume : media(scale)) {
      const MediumAlongRay medium(*volume, ray, *volume->intersect(ray));
      const Interval all = medium.range();
      for (const Interval part :
           {all, Interval{all.t0 + .5f * all.length(), all.t0 + .75f * all.length()}}) {
        const TransmittanceSampler sampler(medium, part);
        if (sampler.isEmpty()) continue;
        const double sum =
            test::integrate([&](double t) { return double{sampler.pdf(static_cast<float>(t))}; },
                            part.t0, part.t1, 2000);
        // The quadrature knows nothing of cell borders; t is rounded to float.
        EXPECT_NEAR(sum, 1, 5e-4);
      }
    }
}

TEST(Falloff, DensityIntegratesToOneAndIsThatOfTheSamples) {
  const Interval range{2, 5};
  for (const double growth : {1e-3, .2, 1., 3., 500.}) {
    const FalloffSampler sampler(range, growth);
    // The integral of the density up to a sample is its random number: F(s) = s (1+bL) / (L
    // (1+bs)).
    for (int i = 0; i < 100; ++i) {
      const float u = (static_cast<float>(i) + .5f) / 100, t = sampler.distance(u);
      const double below = test::integrate(
          [&](double x) { return double{sampler.pdf(static_cast<float>(x))}; }, 2, t, 4000);
      EXPECT_NEAR(below, u, 1e-3) << growth;  // t is rounded to float where the density is 500 / L
    }
  }
}

TEST(DistanceSampling, SamplesAreDistributedAsTheDensity) {
  // Chi-square over 32 cells equal in t: 0.001 quantile of 31 degrees of freedom is 61.1; Sidak for
  // the cases about 80. Cells with fewer than 20 expected are merged.
  constexpr int kCells = 32, kSamples = 20000;
  const Ray ray = rayThroughBox();
  Rng rng(5);
  for (const auto& volume : media(1.f))
    for (const auto& light : {std::optional<Vec3>(), std::optional<Vec3>(Vec3(.5f, .6f, .4f))}) {
      const MediumAlongRay medium(*volume, ray, *volume->intersect(ray));
      const Interval r = medium.range();
      const ScatteringDistanceSampler sampler(medium, r, light);
      std::vector<double> count(kCells, 0);
      for (int i = 0; i < kSamples; ++i) {
        const auto s = sampler.sample(rng.uniform());
        if (!s) continue;
        EXPECT_NEAR(s->pdf, sampler.pdf(s->t), 1e-5f * s->pdf);
        const auto cell = static_cast<int>((s->t - r.t0) / r.length() * kCells);
        ++count[std::clamp(cell, 0, kCells - 1)];
      }
      double chi2 = 0, expected = 0, seen = 0;
      for (int i = 0; i < kCells; ++i) {
        expected +=
            kSamples * test::integrate([&](double t) { return double{sampler.pdf(float(t))}; },
                                       r.t0 + r.length() * float(i) / kCells,
                                       r.t0 + r.length() * float(i + 1) / kCells, 40);
        seen += count[i];
        if (expected < 20 && i + 1 < kCells) continue;
        if (expected > 0) chi2 += sqr(seen - expected) / std::max(expected, 5.0);
        expected = seen = 0;
      }
      EXPECT_LT(chi2, 80);
    }
}

TEST(DistanceSampling, ChromaticWeightsAreBounded) {
  const Ray ray = rayThroughBox();
  Rng rng(6);
  for (const float scale : {1e-6f, 1.f, 1e4f})
    for (const auto& volume : media(scale)) {
      const MediumAlongRay medium(*volume, ray, *volume->intersect(ray));
      const TransmittanceSampler sampler(medium, medium.range());
      if (sampler.isEmpty()) continue;
      float largest = 0;
      for (int i = 0; i < 1000; ++i) {
        const auto s = sampler.sample(rng.uniform());
        if (!s) continue;
        const Rgb weight = medium.at(s->t).sigma_s * medium.transmittance(s->t) * (1 / s->pdf);
        largest = std::max(largest, weight.maxChannel());
      }
      const Rgb& albedo = medium.maxAlbedo();
      EXPECT_LE(largest, (albedo.r + albedo.g + albedo.b) * 1.0001f);
      EXPECT_GT(largest, 0);
    }
}

TEST(DistanceSampling, GreyMediaHaveConstantWeights) {
  const auto volume = test::makeHomogeneous({.sigma_a = Rgb(1.f), .sigma_s = Rgb(2.f)});
  const Ray ray = rayThroughBox();
  const MediumAlongRay medium(*volume, ray, *volume->intersect(ray));
  const TransmittanceSampler sampler(medium, medium.range());
  const float expected = (2.f / 3) * (1 - medium.transmittance().r);
  for (int i = 0; i < 100; ++i) {
    const auto s = sampler.sample(float(i) / 100);
    ASSERT_TRUE(s);
    EXPECT_NEAR(2.f * medium.transmittance(s->t).r / s->pdf, expected, 1e-5);
  }
}

TEST(DistanceSampling, NothingIsDrawnWhereNothingScatters) {
  const auto absorber = test::makeHomogeneous({.sigma_a = Rgb(1.f)});
  const Ray ray = rayThroughBox();
  const MediumAlongRay medium(*absorber, ray, *absorber->intersect(ray));
  EXPECT_TRUE(ScatteringDistanceSampler(medium, medium.range(), Vec3(0)).isEmpty());
}

}  // namespace
}  // namespace brume
