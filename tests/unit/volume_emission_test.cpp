// SPDX-License-Identifier: Apache-2.0
// Emission of media as a distribution: its integral, points drawn from it, the density of the
// directions towards them.
#include <gtest/gtest.h>

#include "core/medium_along_ray.h"
#include "support/volumes.h"

namespace brume {
namespace {

struct Case {
  const char* name;
  std::unique_ptr<Volume> volume;
};

std::vector<Case> cases() {
  test::MediumSpec spec;
  spec.Le = Rgb(1, 2, .5f);
  spec.p0 = Vec3(-.5f, .2f, 0);
  spec.p1 = Vec3(1, 1.4f, .8f);
  spec.volumeToWorld = Transform::translate(Vec3d(.3, -.2, .1)) *
                       Transform::rotate(40, Vec3d(1, 2, 3)) * Transform::scale(1, 2, .5);
  Rng rng(1);
  std::vector<Case> result;
  result.push_back({"homogeneous", test::makeHomogeneous(spec)});
  result.push_back({"falling", test::makeExponential(spec, 2, 3, Vec3(1, 2, -1))});
  result.push_back({"rising", test::makeExponential(spec, .01f, -4, Vec3(.2f, 1, .3f))});
  result.push_back({"grid", test::makeGrid(spec, 4, 3, 5, test::randomDensities(60, rng, .3f))});
  result.push_back({"flat grid", test::makeGrid(spec, 1, 2, 1, {1, 3})});
  return result;
}

/// Le and its integral by the midpoint rule over a box around the volume.
struct Grid {
  static constexpr int kSide = 60;
  Bounds3 box;
  Vec3 size;
  explicit Grid(const Volume& volume) : box(volume.bounds()), size(box.diagonal() / float(kSide)) {}
  template <class F>
  void forEachCell(F&& f) const {
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) f(box.lo + (Vec3(x, y, z) + 0.5f) * size);
  }
  double cellVolume() const { return double{size.x} * double{size.y} * double{size.z}; }
};

TEST(VolumeEmission, TotalIsTheIntegral) {
  for (const Case& c : cases()) {
    const Grid grid(*c.volume);
    double sum[3] = {};
    grid.forEachCell([&](const Vec3& p) {
      const Rgb Le = c.volume->at(p).Le;
      for (int i = 0; i < 3; ++i) sum[i] += double{Le[i]} * grid.cellVolume();
    });
    // The border of a box that stands askew cuts cells: the rule is good to about 1/60 of 1/60.
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(double{c.volume->totalEmission()[i]}, sum[i], 4e-3 * sum[i]) << c.name;
  }
}

TEST(VolumeEmission, PointsFollowIt) {
  // Chi-square over 5^3 bins of the bounding box.
  constexpr int kBins = 5, kPoints = 20000;
  for (const Case& c : cases()) {
    const Grid grid(*c.volume);
    const auto binOf = [&](const Vec3& p) {
      int bin = 0;
      for (int a = 0; a < 3; ++a)
        bin = bin * kBins +
              std::clamp(int((p[a] - grid.box.lo[a]) / (grid.box.hi[a] - grid.box.lo[a]) * kBins),
                         0, kBins - 1);
      return static_cast<std::size_t>(bin);
    };
    std::vector<double> expected(kBins * kBins * kBins), found(expected.size());
    double total = 0;
    grid.forEachCell([&](const Vec3& p) {
      const double Le = double{c.volume->at(p).Le.luminance()};
      expected[binOf(p)] += Le;
      total += Le;
    });
    Rng rng(3);
    for (int i = 0; i < kPoints; ++i) {
      const Vec3 p = c.volume->sampleEmission(rng);
      EXPECT_GT(c.volume->at(p + (Vec3(grid.box.center()) - p) * 1e-5f).Le.g, 0) << c.name;
      found[binOf(p)] += 1;
    }
    double chi2 = 0;
    int bins = 0;
    double rare = 0, rareFound = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const double e = expected[i] / total * kPoints;
      if (e < 20) {
        rare += e;
        rareFound += found[i];
        continue;
      }
      // The expectation itself is good to about a percent at the borders of the box.
      chi2 += sqr(found[i] - e) / (e + sqr(0.01 * e));
      ++bins;
    }
    if (rare > 20) {
      chi2 += sqr(rareFound - rare) / (rare + sqr(0.01 * rare));
      ++bins;
    }
    // Mean bins - 1, deviation sqrt(2 bins): five deviations.
    EXPECT_LT(chi2, bins + 5 * std::sqrt(2.0 * bins)) << c.name;
  }
}

TEST(VolumeEmission, OverlappingVolumesShareByWhatTheyEmit) {
  test::MediumSpec spec;
  spec.Le = Rgb(1);
  const auto weak = test::makeHomogeneous(spec);
  spec.Le = Rgb(3);
  spec.p0 = Vec3(2, 0, 0);
  spec.p1 = Vec3(3, 1, 1);
  const auto strong = test::makeHomogeneous(spec);
  spec.Le = Rgb(0);
  const auto dark = test::makeHomogeneous(spec);
  const auto all = makeAggregateVolume({weak.get(), dark.get(), strong.get()});
  EXPECT_NEAR(all->totalEmission().g, 4, 1e-6);
  Rng rng(4);
  int inStrong = 0;
  for (int i = 0; i < 10000; ++i) inStrong += all->sampleEmission(rng).x > 1.5f;
  EXPECT_NEAR(inStrong, 7500, 5 * std::sqrt(10000 * .75 * .25));
}

TEST(VolumeEmission, SecondMomentIsTheIntegralAlongTheRay) {
  Rng rng(5);
  for (const Case& c : cases())
    for (int i = 0; i < 50; ++i) {
      const Bounds3 box = c.volume->bounds();
      const Vec3 through =
          box.lo + Vec3(rng.uniform(), rng.uniform(), rng.uniform()) * box.diagonal();
      const Vec3 d = test::randomDirection(rng);
      const Ray ray{through - d * (3 * rng.uniform()), d};
      const auto range = c.volume->intersect(ray);
      if (!range) continue;
      const MediumAlongRay medium(*c.volume, ray, *range);
      // From the pieces' own ends on, so that the rule meets no jump.
      const double exact = test::integrate(
          [&](double t) { return double{medium.at(static_cast<float>(t)).Le.luminance()} * t * t; },
          double{range->t0}, double{range->t1}, 400);
      // The float t of at() is off by up to half an ulp at every border of a cell.
      EXPECT_NEAR(medium.secondMomentOfEmission(), exact, 2e-4 * exact + 1e-7) << c.name;
    }
}

}  // namespace
}  // namespace brume
