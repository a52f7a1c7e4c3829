// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "core/medium_along_ray.h"
#include "support/make_plugin.h"
#include "support/volumes.h"
#include "volumes/density_grid.h"

namespace brume {
namespace {

using test::integrate;
using test::makeExponential;
using test::makeGrid;
using test::makeHomogeneous;
using test::MediumSpec;

/// Rays that start inside and outside the unit box, many of them along its faces, edges, voxel
/// planes or axes, or through corners.
std::vector<Ray> nastyRays(Rng& rng, int n, const DensityGrid::Cell& size) {
  std::vector<Ray> rays;
  const auto latticeCoordinate = [&](int a) {
    const float v = float(size[a]);
    switch (rng.below(4)) {
      case 0:
        return rng.uniform();
      case 1:
        return (float(rng.below(size[a])) + .5f) / v;  // a plane of voxel centres
      case 2:
        return float(rng.below(2));  // a face of the box
      default:
        return float(rng.below(size[a] + 1)) / v;
    }
  };
  for (int i = 0; i < n; ++i) {
    Ray ray;
    const Vec3 p(latticeCoordinate(0), latticeCoordinate(1), latticeCoordinate(2));
    switch (rng.below(4)) {
      case 0:
        ray.d = test::randomDirection(rng);
        break;
      case 1: {  // along an axis, with zeros of both signs
        ray.d = Vec3(rng.below(2) ? 0.f : -0.f);
        ray.d[static_cast<int>(rng.below(3))] = rng.below(2) ? 1.f : -1.f;
        break;
      }
      case 2: {  // through another such point
        const Vec3 q(latticeCoordinate(0), latticeCoordinate(1), latticeCoordinate(2));
        const auto d = tryNormalize(q - p);
        ray.d = d ? *d : Vec3(0, 0, 1);
        break;
      }
      default: {  // in a plane
        Vec3 d = test::randomDirection(rng);
        d[static_cast<int>(rng.below(3))] = -0.f;
        ray.d = normalize(d);
      }
    }
    ray.o = p - ray.d * (rng.below(2) ? 0.f : 3.f * rng.uniform());
    ray.tMax = rng.below(2) ? kInfinity : 2.f * rng.uniform();
    rays.push_back(ray);
  }
  return rays;
}

/// The same by quadrature between the crossings of the lattice planes, in double, from at().
double slowDepth(const Volume& volume, const Ray& ray, Interval range,
                 const DensityGrid::Cell& size, const Transform& worldToVolume) {
  std::vector<double> cuts = {range.t0, range.t1};
  const Vec3d o(worldToVolume.matrix() * glm::dvec4(Vec3d(ray.o), 1));
  const Vec3d d(worldToVolume.matrix() * glm::dvec4(Vec3d(ray.d), 0));
  for (int a = 0; a < 3; ++a) {
    if (d[a] == 0) continue;
    const auto cut = [&](double plane) {
      const double t = (plane - o[a]) / d[a];
      if (t > range.t0 && t < range.t1) cuts.push_back(t);
    };
    cut(0);
    cut(1);
    for (int i = 0; i < size[a]; ++i) cut((i + .5) / size[a]);
  }
  std::sort(cuts.begin(), cuts.end());
  double sum = 0;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
    sum += integrate(
        [&](double t) {
          const Vec3 p(Vec3d(ray.o) + t * Vec3d(ray.d));
          return double{volume.at(p).sigma_t().g};
        },
        cuts[i], cuts[i + 1], 1);
  return sum;
}

TEST(VolumeGrid, OpticalDepthIsTheIntegralOfTheDensity) {
  Rng rng(1);
  for (const DensityGrid::Cell& n :
       {DensityGrid::Cell{1, 1, 1}, {2, 1, 3}, {5, 4, 3}, {9, 17, 8}, {40, 3, 70}}) {
    const auto density = test::randomDensities(std::size_t(n[0]) * n[1] * n[2], rng, .3f);
    MediumSpec spec{.sigma_a = Rgb(.5f), .sigma_s = Rgb(1.f, 1.5f, 0.f)};
    const auto grid = makeGrid(spec, n[0], n[1], n[2], density);
    for (const Ray& ray : nastyRays(rng, 150, n)) {
      const auto range = grid->intersect(ray);
      if (!range) continue;
      const Rgb tau = grid->opticalDepth(ray, *range);
      // Positions are rounded to float before the density is looked up: 1e-7 of |p| against a
      // voxel.
      const double tolerance = 4e-6 * std::max({n[0], n[1], n[2]}) * range->length() + 1e-6;
      ASSERT_NEAR(tau.g, slowDepth(*grid, ray, *range, n, Transform()), tolerance);
      EXPECT_NEAR(tau.r, .75f * tau.g, 1e-6f * tau.g);
      EXPECT_NEAR(tau.b, .25f * tau.g, 1e-6f * tau.g);
      // Nothing lies outside the interval that intersect gives, and parts add up.
      const float far = std::min(ray.tMax, 20.f);
      EXPECT_NEAR(grid->opticalDepth(ray, {0, far}).g, tau.g, 1e-6f * tau.g);
      const float middle = range->t0 + .37f * range->length();
      EXPECT_NEAR(grid->opticalDepth(ray, {range->t0, middle}).g +
                      grid->opticalDepth(ray, {middle, range->t1}).g,
                  tau.g, 1e-6f * tau.g + 1e-30f);
    }
  }
}

TEST(VolumeGrid, RaysThatMissSeeNothing) {
  Rng rng(2);
  const auto grid = makeGrid({.sigma_a = Rgb(1.f)}, 4, 4, 4, test::randomDensities(64, rng));
  EXPECT_FALSE(grid->intersect({{2, .5f, .5f}, {1, 0, 0}}));
  EXPECT_FALSE(grid->intersect({{-1, 2, .5f}, {1, 0, -0.f}}));
  EXPECT_FALSE(grid->intersect({{-2, .5f, .5f}, {1, 0, 0}, 1.5f}));
  EXPECT_TRUE(grid->intersect({{-2, .5f, .5f}, {1, 0, 0}, 2.5f}));
  EXPECT_EQ(grid->opticalDepth({{-2, .5f, .5f}, {1, 0, 0}}, {0, 1.5f}), Rgb(0.f));
  EXPECT_EQ(grid->at({1.5f, .5f, .5f}).sigma_t(), Rgb(0.f));
}

TEST(VolumeGrid, IsConstantInTheOuterHalfVoxelAndTrilinearBetweenCentres) {
  const auto grid = makeGrid({.sigma_a = Rgb(1.f)}, 2, 1, 1, {1.f, 3.f});
  EXPECT_FLOAT_EQ(grid->at({.1f, .5f, .5f}).sigma_a.r, 1.f);
  EXPECT_FLOAT_EQ(grid->at({.25f, .1f, .9f}).sigma_a.r, 1.f);
  EXPECT_FLOAT_EQ(grid->at({.5f, .5f, .5f}).sigma_a.r, 2.f);
  EXPECT_FLOAT_EQ(grid->at({.9f, .5f, .5f}).sigma_a.r, 3.f);
  EXPECT_FLOAT_EQ(grid->opticalDepth({{-1, .5f, .5f}, {1, 0, 0}}, {0, 9}).r, 2.f);
  EXPECT_FLOAT_EQ(grid->majorant().r, 3.f);
  // x is the fastest index.
  const auto order = makeGrid({.sigma_a = Rgb(1.f)}, 2, 3, 1, {0, 1, 2, 3, 4, 5});
  EXPECT_FLOAT_EQ(order->at({.75f, .5f, .5f}).sigma_a.r, 3.f);
}

TEST(VolumeGrid, EmptySpaceIsSkippedAndTheIntervalIsTight) {
  constexpr int n = 128;
  std::vector<float> density(std::size_t(n) * n * n, 0.f);
  density[(std::size_t(64) * n + 64) * n + 64] = 1.f;
  const auto grid = makeGrid({.sigma_a = Rgb(1.f)}, n, n, n, density);
  EXPECT_FALSE(grid->intersect({{-1, .1f, .1f}, {1, 0, 0}}));
  const auto range = grid->intersect({{-1, 64.5f / n, 64.5f / n}, {1, 0, 0}});
  ASSERT_TRUE(range);
  EXPECT_LE(range->length(), 17.f / n);
  EXPECT_NEAR(grid->opticalDepth({{-1, 64.5f / n, 64.5f / n}, {1, 0, 0}}, {0, 9}).r, 1.f / n,
              1e-6f);
}

TEST(VolumeGrid, VisitsOnlyOccupiedBlocks) {
  constexpr int n = 100;
  std::vector<float> density(std::size_t(n) * n * n, 0.f);
  for (int z = 40; z < 50; ++z)
    for (int y = 40; y < 50; ++y)
      for (int x = 40; x < 50; ++x) density[(std::size_t(z) * n + y) * n + x] = 1.f;
  const DensityGrid grid(density, {n, n, n});
  int cells = 0;
  double last = 0;
  grid.walk({{0.5, 45.3, 45.1}, {1, 0, 0}}, 0, n, 0, [&](const auto& cell, double t0, double t1) {
    EXPECT_GE(t0, last);
    EXPECT_GT(t1, t0);
    EXPECT_GE(cell[0], 40);
    EXPECT_LT(cell[0], 56);
    last = t1;
    ++cells;
    return true;
  });
  EXPECT_EQ(cells, 16);
  EXPECT_LT(double(grid.overheadBytes()), .01 * double(density.size()) * 4);
}

TEST(VolumeGrid, LoadsFastWithLittleMemory) {
  constexpr int n = 256;
  std::vector<float> density(std::size_t(n) * n * n);
  for (std::size_t i = 0; i < density.size(); i += 7) density[i] = 1.f;
  const auto start = std::chrono::steady_clock::now();
  const DensityGrid grid(std::move(density), {n, n, n});
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  EXPECT_LT(seconds.count(), 1);
  EXPECT_LT(double(grid.overheadBytes()) / (double(n) * n * n), .02);  // bytes per voxel
}

std::string gridError(int nx, int ny, int nz, std::size_t count) {
  try {
    makeGrid({}, nx, ny, nz, std::vector<float>(count));
  } catch (const SceneError& e) {
    return e.what();
  }
  return "";
}

TEST(VolumeGrid, CountsAreCheckedBeforeAnythingIsAllocated) {
  EXPECT_THAT(gridError(2, 2, 2, 7), testing::HasSubstr("has 7 values"));
  EXPECT_THAT(gridError(2147483647, 2147483647, 2147483647, 1), testing::HasSubstr("asks for 99"));
  EXPECT_THAT(gridError(65536, 65536, 65536, 1), testing::HasSubstr("281474976710656"));
  EXPECT_NE(gridError(0, 1, 1, 0), "");
  EXPECT_EQ(gridError(1, 1, 1, 1), "");
}

std::vector<std::unique_ptr<Volume>> zoo(const MediumSpec& spec, Rng& rng) {
  std::vector<std::unique_ptr<Volume>> all;
  all.push_back(makeHomogeneous(spec));
  for (const float b : {0.f, 1e-9f, 1e-3f, 2.f, 60.f, -30.f})
    all.push_back(makeExponential(spec, 1.3f, b, {.3f, 1, .2f}));
  all.push_back(makeGrid(spec, 7, 12, 3, test::randomDensities(7 * 12 * 3, rng, .3f)));
  all.push_back(makeGrid(spec, 1, 1, 1, {1.f}));
  return all;
}

TEST(Volumes, InversionIsTheInverseOfOpticalDepth) {
  Rng rng(7);
  MediumSpec spec{.sigma_a = Rgb(.5f, 2.f, 30.f), .sigma_s = Rgb(1.f)};
  for (const auto& volume : zoo(spec, rng))
    for (int i = 0; i < 300; ++i) {
      Ray ray{{3 * rng.uniform() - 1, 3 * rng.uniform() - 1, 3 * rng.uniform() - 1},
              test::randomDirection(rng)};
      const auto range = volume->intersect(ray);
      if (!range) continue;
      const int channel = static_cast<int>(rng.below(3));
      const float total = volume->opticalDepth(ray, *range)[channel];
      const float target = total * rng.uniform();
      if (target == 0) continue;
      const auto t = volume->invertOpticalDepth(ray, *range, channel, target);
      ASSERT_TRUE(t);
      EXPECT_GE(*t, range->t0);
      EXPECT_LE(*t, range->t1);
      // t is a float: its rounding times the density there, and that of the target.
      const double slack =
          double{volume->majorant()[channel]} * 2e-7 * double{range->t1} + 4e-7 * double{target};
      EXPECT_NEAR(volume->opticalDepth(ray, {range->t0, *t})[channel], target, slack);
      EXPECT_FALSE(volume->invertOpticalDepth(ray, *range, channel, total * 1.001f + 1e-30f));
      EXPECT_EQ(volume->invertOpticalDepth(ray, *range, channel, 0.f), range->t0);
    }
}

TEST(Volumes, PiecesHoldTheWholeMedium) {
  Rng rng(8);
  MediumSpec spec{.sigma_a = Rgb(.5f, 2.f, 3.f), .sigma_s = Rgb(1.f), .Le = Rgb(1, 2, 3)};
  for (const auto& volume : zoo(spec, rng))
    for (int i = 0; i < 100; ++i) {
      Ray ray{{3 * rng.uniform() - 1, 3 * rng.uniform() - 1, 3 * rng.uniform() - 1},
              test::randomDirection(rng)};
      const auto range = volume->intersect(ray);
      if (!range) continue;
      const MediumAlongRay record(*volume, ray, *range);
      for (int k = 0; k <= 8; ++k) {
        const float t = range->t0 + range->length() * float(k) / 8;
        const Rgb expected = volume->opticalDepth(ray, {range->t0, t});
        EXPECT_NEAR(record.opticalDepth(t).g, expected.g, 1e-6f * expected.g + 1e-30f);
        if (k == 0 || k == 8) continue;
        // at() rounds the position to float.
        EXPECT_NEAR(record.at(t).sigma_t().g, volume->at(ray(t)).sigma_t().g,
                    4e-5f * volume->majorant().g);
      }
      const Rgb emission = volume->emission(ray, *range);
      EXPECT_NEAR(record.emission().b, emission.b, 1e-5f * emission.b);
      const float target = .4f * record.opticalDepth().r;
      const auto a = record.invert(0, double{target});
      const auto b = volume->invertOpticalDepth(ray, *range, 0, target);
      ASSERT_EQ(a.has_value(), b.has_value());
      if (!a || target == 0) continue;
      EXPECT_NEAR(*a, *b, 1e-5f);
    }
}

TEST(Volumes, EmissionIsTheAttenuatedIntegral) {
  Rng rng(9);
  for (const float scale : {1e-6f, 1e-3f, 1.f, 30.f}) {
    MediumSpec spec{.sigma_a = Rgb(0, scale, 3 * scale), .Le = Rgb(1.f, 2.f, .5f)};
    for (const auto& volume : zoo(spec, rng)) {
      const Ray ray{{-.5f, .2f, .3f}, normalize(Vec3(1, .3f, .1f))};
      const auto range = volume->intersect(ray);
      ASSERT_TRUE(range);
      // The quadrature below resolves an optical depth of 1 per interval.
      if (volume->majorant().b > 300) continue;
      const Rgb emission = volume->emission(ray, *range);
      for (int c = 0; c < 3; ++c) {
        const double expected = integrate(
            [&](double t) {
              const Interval before{range->t0, static_cast<float>(t)};
              return double{volume->at(ray(float(t))).Le[c]} *
                     std::exp(-double{volume->opticalDepth(ray, before)[c]});
            },
            range->t0, range->t1, 400);
        // The quadrature crosses the cells of a grid without looking: 1e-4.
        EXPECT_NEAR(emission[c] / expected, 1, 1e-4);
      }
    }
  }
}

TEST(Volumes, SlabOfEmittingFog) {
  // Le (1 - exp(-tau)) / sigma_t, and Le s when there is no absorption.
  MediumSpec spec{.sigma_a = Rgb(0, 1e-7f, 5.f), .Le = Rgb(2.f)};
  const auto volume = makeHomogeneous(spec);
  const Ray ray{{.5f, .5f, -1}, {0, 0, 1}};
  const Rgb e = volume->emission(ray, {0, 10});
  EXPECT_FLOAT_EQ(e.r, 2.f);
  EXPECT_FLOAT_EQ(e.g, 2.f * (1 - .5e-7f));
  EXPECT_FLOAT_EQ(e.b, 2.f * static_cast<float>((1 - std::exp(-5.0)) / 5));
  EXPECT_FLOAT_EQ(volume->transmittance(ray).b, static_cast<float>(std::exp(-5.0)));
}

TEST(Volumes, ExponentialAgreesWithItsClosedForm) {
  MediumSpec spec{.sigma_a = Rgb(1.f), .p1 = Vec3(1, 10, 1)};
  const auto volume = makeExponential(spec, 2.f, .7f);
  const Ray up{{.5f, -1, .5f}, {0, 1, 0}};
  EXPECT_NEAR(volume->opticalDepth(up, {0, 20}).r, 2 * (1 - std::exp(-7.0)) / .7, 1e-6);
  const Ray down{{.5f, 11, .5f}, {0, -1, 0}};
  EXPECT_NEAR(volume->opticalDepth(down, {0, 20}).r, 2 * (1 - std::exp(-7.0)) / .7, 1e-6);
  const Ray level{{-1, 3, .5f}, {1, 0, 0}};
  EXPECT_NEAR(volume->opticalDepth(level, {0, 20}).r, 2 * std::exp(-2.1), 1e-6);
  // A density that underflows on the way keeps both its ends.
  const auto steep = makeExponential(spec, 2.f, 1e4f);
  EXPECT_NEAR(steep->opticalDepth(down, {0, 20}).r, 2e-4, 1e-9);
  const auto t = steep->invertOpticalDepth(down, {0, 20}, 0, 1e-4f);
  ASSERT_TRUE(t);
  EXPECT_NEAR(*t, 11, 1e-3);
  EXPECT_THROW(makeExponential(spec, 1.f, -1e3f), SceneError);
  EXPECT_THROW(makeExponential(spec, 1.f, 1.f, Vec3(0)), SceneError);
}

TEST(Volumes, EqualMediaOfAllKindsAgree) {
  Rng rng(11);
  MediumSpec spec{.sigma_a = Rgb(.1f, .2f, .3f), .sigma_s = Rgb(1.f, .5f, 2.f), .Le = Rgb(1.f)};
  spec.volumeToWorld = Transform::rotate(30, {1, 2, 3}) * Transform::scale(2, 3, .5);
  const auto a = makeHomogeneous(spec);
  const auto b = makeExponential(spec, 1.f, 0.f);
  const auto c = makeGrid(spec, 5, 9, 14, std::vector<float>(5 * 9 * 14, 1.f));
  for (int i = 0; i < 500; ++i) {
    Ray ray{{4 * rng.uniform() - 2, 4 * rng.uniform() - 2, 4 * rng.uniform() - 2},
            test::randomDirection(rng)};
    const auto range = a->intersect(ray);
    ASSERT_EQ(range.has_value(), c->intersect(ray).has_value());
    if (!range) continue;
    EXPECT_EQ(range->t0, c->intersect(ray)->t0);
    EXPECT_EQ(range->t1, c->intersect(ray)->t1);
    const Rgb tau = a->opticalDepth(ray, *range);
    EXPECT_EQ(tau, b->opticalDepth(ray, *range));
    EXPECT_NEAR(c->opticalDepth(ray, *range).r, tau.r, 2e-7f * tau.r);
    const auto ta = a->invertOpticalDepth(ray, *range, 1, .3f * tau.g);
    const auto tc = c->invertOpticalDepth(ray, *range, 1, .3f * tau.g);
    ASSERT_TRUE(ta && tc);
    EXPECT_NEAR(*ta, *tc, 1e-6f * std::max(1.f, *ta));
    EXPECT_NEAR(a->emission(ray, *range).b, c->emission(ray, *range).b, 1e-6f);
  }
}

TEST(Volumes, CoefficientsArePerWorldLengthWhateverTheTransform) {
  MediumSpec spec{.sigma_a = Rgb(1.f)};
  spec.volumeToWorld = Transform::scale(1, 1, 4);
  for (const auto& volume :
       {makeHomogeneous(spec), makeGrid(spec, 2, 2, 2, std::vector<float>(8, 1.f))})
    EXPECT_FLOAT_EQ(volume->opticalDepth({{.5f, .5f, -1}, {0, 0, 1}}, {0, 10}).r, 4.f);
}

TEST(Volumes, ScaledScenesHaveTheSameDepths) {
  Rng rng(13);
  const auto density = test::randomDensities(6 * 5 * 4, rng, .2f);
  const Ray ray{{-.3f, .2f, .1f}, normalize(Vec3(1, .4f, .5f))};
  const Rgb expected = makeGrid({.sigma_a = Rgb(3.f)}, 6, 5, 4, density)->opticalDepth(ray, {0, 9});
  for (const float s : {1e-6f, 1e-3f, 1e3f, 1e6f}) {
    MediumSpec spec{.sigma_a = Rgb(3.f / s)};
    spec.volumeToWorld = Transform::scale(s, s, s);
    const auto volume = makeGrid(spec, 6, 5, 4, density);
    EXPECT_NEAR(volume->opticalDepth({ray.o * s, ray.d}, {0, 9 * s}).r, expected.r, 4e-6f);
  }
}

TEST(Volumes, ExtremeDensitiesAndDepthsStayFinite) {
  std::vector<float> density(64);
  for (std::size_t i = 0; i < 64; ++i)
    density[i] = i % 4 == 0 ? 0.f : i % 4 == 1 ? 1e-40f : i % 4 == 2 ? 1e10f : 1.f;
  for (const float sigma : {1e-30f, 1e-6f, 1.f, 1e4f, 1e19f}) {
    MediumSpec spec{.sigma_a = Rgb(sigma), .sigma_s = Rgb(0, sigma, sigma), .Le = Rgb(1.f)};
    const auto grid = makeGrid(spec, 4, 4, 4, density);
    Rng rng(14);
    for (const Ray& ray : nastyRays(rng, 100, {4, 4, 4})) {
      const auto range = grid->intersect(ray);
      if (!range) continue;
      const Rgb tr = grid->transmittance(ray, *range);
      EXPECT_TRUE(tr.isFinite());
      EXPECT_GE(tr.minChannel(), 0);
      EXPECT_LE(tr.maxChannel(), 1);
      const Rgb e = grid->emission(ray, *range);
      EXPECT_TRUE(e.isFinite());
      EXPECT_GE(e.minChannel(), 0);
      const float tau = grid->opticalDepth(ray, *range).g;
      if (tau > 0 && std::isfinite(tau)) {
        const auto t = grid->invertOpticalDepth(ray, *range, 1, .5f * tau);
        ASSERT_TRUE(t);
        EXPECT_TRUE(*t >= range->t0 && *t <= range->t1);
      }
    }
  }
}

TEST(Volumes, FlatBoxesHoldNothingAndSaySo) {
  MediumSpec spec{.sigma_a = Rgb(1.f), .Le = Rgb(1.f), .p1 = Vec3(1, 1, 0)};
  const auto before = test::captureLog().warningCount();
  const auto flat = makeGrid(spec, 1, 1, 1, {1.f});
  EXPECT_EQ(test::captureLog().warningCount(), before + 1);
  EXPECT_FALSE(flat->intersect({{.5f, .5f, -1}, {0, 0, 1}}));
  EXPECT_EQ(flat->at({.5f, .5f, 0}).sigma_a, Rgb(0.f));
  const Rgb tau = flat->opticalDepth({{-1, .5f, 0}, {1, 0, 0}}, {0, 5});
  EXPECT_EQ(tau, Rgb(0.f));
}

TEST(Volumes, NegativeColoursAreTakenAsZeroWithAWarning) {
  const auto before = test::captureLog().warningCount();
  const auto v = makeHomogeneous({.sigma_a = Rgb(1.f, -.1f, 0), .Le = Rgb(1, 1, -1)});
  EXPECT_EQ(test::captureLog().warningCount(), before + 2);
  EXPECT_EQ(v->at({.5f, .5f, .5f}).sigma_a, Rgb(1, 0, 0));
}

TEST(Volumes, KnowWhetherTheyScatterAndEmit) {
  EXPECT_FALSE(makeHomogeneous({.sigma_a = Rgb(1.f)})->isScattering());
  EXPECT_TRUE(makeHomogeneous({.sigma_s = Rgb(0, 0, 1)})->isScattering());
  EXPECT_TRUE(makeHomogeneous({.Le = Rgb(0, 0, 1)})->isEmissive());
  EXPECT_FALSE(makeGrid({.sigma_s = Rgb(1.f), .Le = Rgb(1.f)}, 1, 1, 1, {0.f})->isScattering());
}

TEST(Aggregate, TwoHalvesAreOneWhole) {
  Rng rng(15);
  MediumSpec spec{.sigma_a = Rgb(1.f), .sigma_s = Rgb(.2f, .4f, .8f), .Le = Rgb(1, 2, 3)};
  const auto whole = makeHomogeneous(spec);
  MediumSpec left = spec, right = spec, half = spec;
  left.p1.x = right.p0.x = .5f;
  half.sigma_a *= .5f;
  half.sigma_s *= .5f;
  half.Le *= .5f;
  const auto a = makeHomogeneous(left), b = makeHomogeneous(right);
  const auto c = makeHomogeneous(half);
  const auto d = makeGrid(half, 4, 3, 5, std::vector<float>(60, 1.f));
  const auto sideBySide = makeAggregateVolume({a.get(), b.get()});
  const auto overlapping = makeAggregateVolume({c.get(), d.get()});
  const auto nested = makeAggregateVolume({overlapping.get()});
  // So many that a tree finds them.
  std::vector<std::unique_ptr<Volume>> slices;
  std::vector<const Volume*> allSlices;
  for (int i = 0; i < 32; ++i) {
    MediumSpec slice = spec;
    slice.p0.x = static_cast<float>(i) / 32;
    slice.p1.x = static_cast<float>(i + 1) / 32;
    allSlices.push_back(slices.emplace_back(makeHomogeneous(slice)).get());
  }
  const auto sliced = makeAggregateVolume(allSlices);
  for (int i = 0; i < 200; ++i) {
    Ray ray{{3 * rng.uniform() - 1, 3 * rng.uniform() - 1, 3 * rng.uniform() - 1},
            test::randomDirection(rng)};
    const auto range = whole->intersect(ray);
    if (!range) continue;
    const Rgb tau = whole->opticalDepth(ray, *range), e = whole->emission(ray, *range);
    for (const Volume* sum : {sideBySide.get(), overlapping.get(), nested.get(), sliced.get()}) {
      ASSERT_TRUE(sum->intersect(ray));
      EXPECT_NEAR(sum->opticalDepth(ray, *range).b, tau.b, 1e-6f);
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(sum->emission(ray, *range)[k], e[k], 2e-6f * e[k]);
      const auto t = sum->invertOpticalDepth(ray, *range, 0, .7f * tau.r);
      ASSERT_TRUE(t);
      EXPECT_NEAR(*t, *whole->invertOpticalDepth(ray, *range, 0, .7f * tau.r), 1e-6f);
    }
    EXPECT_NEAR(overlapping->at(ray(range->t0 + .5f * range->length())).Le.g, 2, 1e-6);
    const Vec3 inside = ray(range->t0 + .7f * range->length()), wo = test::randomDirection(rng),
               wi = test::randomDirection(rng);
    EXPECT_EQ(sliced->at(inside).sigma_s, whole->at(inside).sigma_s);
    EXPECT_NEAR(sliced->phase(inside, wo, wi).g, whole->phase(inside, wo, wi).g, 1e-6);
    EXPECT_TRUE(whole->bounds().contains(sliced->sampleEmission(rng)));
  }
}

TEST(Aggregate, AttenuatesEmissionByTheTotalMedium) {
  Rng rng(16);
  MediumSpec fire{.Le = Rgb(1, 2, 3)}, smoke{.sigma_a = Rgb(0, 2.f, 40.f)};
  fire.sigma_a = Rgb(.1f);
  const auto a = makeGrid(fire, 5, 4, 3, test::randomDensities(60, rng));
  const auto b = makeExponential(smoke, 1.f, 3.f, {1, 1, 0});
  const auto c = makeHomogeneous({.sigma_a = Rgb(.3f), .p0 = Vec3(.2f), .p1 = Vec3(.7f)});
  const auto sum = makeAggregateVolume({a.get(), b.get(), c.get()});
  for (int i = 0; i < 20; ++i) {
    const Ray ray{{-.2f, rng.uniform(), rng.uniform()}, normalize(Vec3(1, .3f, .1f))};
    const auto range = sum->intersect(ray);
    if (!range) continue;
    const Rgb e = sum->emission(ray, *range);
    for (int k = 0; k < 3; ++k) {
      const double expected = integrate(
          [&](double t) {
            const Interval before{range->t0, static_cast<float>(t)};
            return double{sum->at(ray(float(t))).Le[k]} *
                   std::exp(-double{sum->opticalDepth(ray, before)[k]});
          },
          range->t0, range->t1, 300);
      // The quadrature ignores the ends of boxes and cells, and rounds t to float.
      EXPECT_NEAR(e[k] / expected, 1, 3e-4);
    }
    const float tau = sum->opticalDepth(ray, *range).g;
    const auto t = sum->invertOpticalDepth(ray, *range, 1, .3f * tau);
    ASSERT_TRUE(t);
    EXPECT_NEAR(sum->opticalDepth(ray, {range->t0, *t}).g, .3f * tau, 2e-6f * (1 + tau));
  }
}

TEST(Aggregate, OpaqueOverlapsStillEmitRightly) {
  // Source function Le / sigma_t of an opaque sum; 1e6 optical depths.
  const auto a = makeHomogeneous({.sigma_a = Rgb(1e6f), .Le = Rgb(3e6f)});
  const auto b = makeHomogeneous({.sigma_a = Rgb(2e6f), .Le = Rgb(0, 3e6f, 0)});
  const auto sum = makeAggregateVolume({a.get(), b.get()});
  const Rgb e = sum->emission({{.5f, .5f, -1}, {0, 0, 1}}, {0, 5});
  EXPECT_NEAR(e.r, 1, 1e-6);
  EXPECT_NEAR(e.g, 2, 1e-6);
}

TEST(Aggregate, EachVolumeScattersByItsOwnPhaseFunction) {
  const auto a = makeHomogeneous({.sigma_s = Rgb(1, .2f, 0), .g = .6f});
  const auto b = makeHomogeneous({.sigma_s = Rgb(0, .6f, 2), .p1 = Vec3(1, 1, .5f), .g = -.2f});
  const auto sum = makeAggregateVolume({a.get(), b.get()});
  const Vec3 wo(0, 0, 1), p(.5f, .5f, .25f), alone(.5f, .5f, .75f);
  const Vec3 wi = normalize(Vec3(1, 0, -1));
  const Rgb expected =
      a->at(p).sigma_s * a->phase(p, wo, wi) + b->at(p).sigma_s * b->phase(p, wo, wi);
  const Rgb scattered = sum->at(p).sigma_s * sum->phase(p, wo, wi);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(scattered[c], expected[c], 1e-6f * expected[c]);
  EXPECT_EQ(sum->phase(alone, wo, wi), a->phase(alone, wo, wi));
}

TEST(Aggregate, PhaseIsSampledByWhatIsCarried) {
  const auto a = makeHomogeneous({.sigma_s = Rgb(1, .2f, 0), .g = .6f});
  const auto b = makeHomogeneous({.sigma_s = Rgb(0, .6f, 2), .g = -.2f});
  const auto sum = makeAggregateVolume({a.get(), b.get()});
  const Vec3 wo(0, 0, 1), p(.5f);
  Rng rng(4);
  for (const Rgb& carried : {Rgb(1.f), Rgb(0, 1, 0), Rgb(.1f, 0, 2)}) {
    // Shares of a: 1, 1/4, 0; the sampled mean cosine is the carried mean of .6 share - .2 (1 -
    // share), and so is that of the values per channel. Sigma of both means below .005, .02.
    const Rgb share(1, .25f, 0);
    double mean = 0, expected = 0, carriedSum = 0;
    Vec3d meanOfChannel(0);
    constexpr int kSamples = 20000;
    for (int i = 0; i < kSamples; ++i) {
      const float u = rng.uniform();
      const ScatterSample s = sum->samplePhase(p, wo, carried, u, rng.uniform2());
      ASSERT_EQ(s.value, sum->phase(p, wo, s.wi));
      ASSERT_EQ(s.pdf, phasePdf(s.value, carried));
      // What is carried on is what came, whatever the direction.
      const Rgb after = carried * s.value / s.pdf;
      ASSERT_NEAR(after.r + after.g + after.b, carried.r + carried.g + carried.b, 1e-5);
      const double cosine = -double{dot(s.wi, wo)} / kSamples;
      mean += cosine;
      for (int c = 0; c < 3; ++c) meanOfChannel[c] += cosine * double{s.value[c] / s.pdf};
    }
    for (int c = 0; c < 3; ++c) {
      const double g = .6 * double{share[c]} - .2 * (1 - double{share[c]});
      expected += double{carried[c]} * g;
      carriedSum += double{carried[c]};
      if (carried[c] > 0) {
        EXPECT_NEAR(meanOfChannel[c], g, .06) << c;
      }
    }
    EXPECT_NEAR(mean, expected / carriedSum, .015);
  }
}

}  // namespace
}  // namespace brume
