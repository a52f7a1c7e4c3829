// SPDX-License-Identifier: Apache-2.0
// Tables of optical depth against the media they are made from.
#include "transport/depth_tables.h"

#include <gtest/gtest.h>

#include "support/volumes.h"

namespace brume {
namespace {

using test::MediumSpec;

/// Rays through and past the box [-1, 1]^3, from `distance` away.
void expectDepths(const Volume& volume, float distance, double relative, bool wantGrey) {
  Rng rng(5);
  DepthTables tables;
  tables.reset(200);
  // s is a float, up to distance + 2.5.
  const double rounding = 2e-6 + double{volume.majorant().maxChannel() * 1e-7f * (distance + 2.5f)};
  double deepest = 0;
  for (std::size_t table = 0; table < 200; ++table) {
    const Vec3 d = test::randomDirection(rng);
    const Vec3 through(2.2f * rng.uniform() - 1.1f, 2.2f * rng.uniform() - 1.1f,
                       2.2f * rng.uniform() - 1.1f);
    const Ray ray{through - distance * d, d, kInfinity, 0};
    const float t0 = std::max(0.f, distance - 2.5f);
    const MediumAlongRay medium(volume, ray, {t0, distance + 2.5f});
    ASSERT_FALSE(tables.isFilled(table));
    tables.fill(table, medium, t0);
    ASSERT_TRUE(tables.isFilled(table));
    for (int i = 0; i <= 100; ++i) {
      const float t = std::clamp(t0 + 5.f * (i % 2 ? rng.uniform() : static_cast<float>(i) / 100),
                                 t0, distance + 2.5f);
      const DepthTables::Depth depth = tables.at(table, t - t0);
      const Vec3d expected = medium.depthAt(double{t});
      for (int c = 0; c < 3; ++c) {
        const auto k = static_cast<std::size_t>(c);
        EXPECT_NEAR(depth.of[k], expected[c], relative * expected[c] + rounding)
            << t << " " << table;
        EXPECT_GE(depth.of[k], -1e-30f);
        EXPECT_TRUE(!depth.isGrey || depth.of[k] == depth.of[0]);
        deepest = std::max(deepest, double{depth.of[k]});
      }
      EXPECT_TRUE(depth.isGrey == wantGrey || medium.isEmpty());
    }
  }
  EXPECT_GT(deepest, 0.5);
}

MediumSpec box(const Rgb& sigma_s, const Rgb& sigma_a = Rgb(0.25f)) {
  MediumSpec spec;
  spec.sigma_s = sigma_s;
  spec.sigma_a = sigma_a;
  spec.p0 = Vec3(-1);
  spec.p1 = Vec3(1);
  return spec;
}

TEST(DepthTables, FollowHomogeneousMedia) {
  expectDepths(*test::makeHomogeneous(box(Rgb(1, 2, 3))), 2, 3e-6, false);
  expectDepths(*test::makeHomogeneous(box(Rgb(2))), 0, 3e-6, true);
}

TEST(DepthTables, FollowGrids) {
  Rng rng(7);
  const auto grid =
      test::makeGrid(box(Rgb(1, 2, 3)), 9, 5, 7, test::randomDensities(9 * 5 * 7, rng, 0.4f));
  expectDepths(*grid, 3, 3e-6, false);
  expectDepths(*grid, 0, 3e-6, false);
  const auto grey =
      test::makeGrid(box(Rgb(4)), 9, 5, 7, test::randomDensities(9 * 5 * 7, rng, 0.4f));
  expectDepths(*grey, 1000, 3e-6, true);
}

TEST(DepthTables, FollowSteepExponentials) {
  for (const float b : {0.1f, 3.f, 100.f, 3000.f}) {
    SCOPED_TRACE(b);
    expectDepths(*test::makeExponential(box(Rgb(1, 2, 3) * (1 + b)), 1, b), 2, 5e-6, false);
  }
}

TEST(DepthTables, AddOverlappingMedia) {
  Rng rng(8);
  MediumSpec inner = box(Rgb(3, 2, 1));
  inner.p1 = Vec3(0.3f);
  const auto grid = test::makeGrid(inner, 4, 4, 4, test::randomDensities(64, rng, 0.2f));
  const auto haze = test::makeExponential(box(Rgb(0.5f)), 1, 4);
  const auto fog = test::makeHomogeneous(box(Rgb(0.1f, 0.2f, 0.3f)));
  expectDepths(*makeAggregateVolume({grid.get(), haze.get(), fog.get()}), 2, 5e-6, false);
  const auto other = test::makeHomogeneous(box(Rgb(2)));
  expectDepths(*makeAggregateVolume({haze.get(), other.get()}), 2, 5e-6, true);
}

TEST(DepthTables, AreForgottenWhenTheyGrowTooLarge) {
  // 64^3 cells: some hundred pieces each; more rays than there is room for.
  Rng rng(9);
  const auto grid = test::makeGrid(box(Rgb(1)), 400, 4, 4, test::randomDensities(400 * 16, rng));
  const MediumAlongRay medium(*grid, Ray{{-2, 0.1f, 0.2f}, {1, 0, 0}, kInfinity, 0}, {0, 4});
  ASSERT_GT(medium.spans().size(), 300u);
  const std::size_t count = DepthTables::kMostSegments / medium.spans().size() + 2;
  DepthTables tables;
  tables.reset(count);
  for (std::size_t i = 0; i < count; ++i) tables.fill(i, medium, 0);
  EXPECT_FALSE(tables.isFilled(0));
  ASSERT_TRUE(tables.isFilled(count - 1));
  EXPECT_NEAR(tables.at(count - 1, 4).of[0], medium.depthAt(4).x, 3e-6 * medium.depthAt(4).x);
}

}  // namespace
}  // namespace brume
