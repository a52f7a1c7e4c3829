// SPDX-License-Identifier: Apache-2.0
#include "accelerators/photon_kdtree.h"

#include <gtest/gtest.h>

#include <numeric>

#include "core/error.h"
#include "support/point_sets.h"

namespace brume {
namespace {

constexpr int kPoints = 3000, kQueries = 40;

/// As the tree computes it.
float distance2(const Vec3& a, const Vec3& b) {
  const Vec3 d = a - b;
  return d.x * d.x + d.y * d.y + d.z * d.z;
}

/// All points of the tree, nearest first.
std::vector<Neighbour> byDistance(const PhotonKdTree& tree, const Vec3& p) {
  std::vector<Neighbour> all;
  for (std::size_t i = 0; i < tree.size(); ++i)
    all.emplace_back(distance2(p, tree.point(i)), static_cast<std::uint32_t>(i));
  std::sort(all.begin(), all.end());
  return all;
}

/// Calls f(tree, p) with places of each set, some of them points of the tree.
template <class F>
void forEachQuery(F&& f) {
  for (const test::PointSet& set : test::pointSets(kPoints)) {
    SCOPED_TRACE(set.name);
    const PhotonKdTree tree{std::span<const Vec3>(set.points)};
    Rng rng(7);
    for (int q = 0; q < kQueries; ++q) {
      const bool atPoint = q % 4 == 0 && tree.size() > 0;
      f(tree, set,
        atPoint ? tree.point(rng.below(static_cast<std::uint32_t>(tree.size())))
                : test::randomInBox(rng, set.middle, 1.2f * set.size));
    }
  }
}

TEST(PhotonKdTree, HoldsEachPointOnceInTheOrderItTells) {
  for (const test::PointSet& set : test::pointSets(kPoints)) {
    SCOPED_TRACE(set.name);
    const PhotonKdTree tree{std::span<const Vec3>(set.points)};
    ASSERT_EQ(tree.size(), set.points.size());
    std::vector<std::uint32_t> seen(tree.order().begin(), tree.order().end());
    for (std::size_t i = 0; i < seen.size(); ++i)
      EXPECT_EQ(tree.point(i), set.points[seen[i]]) << i;
    std::sort(seen.begin(), seen.end());
    for (std::size_t i = 0; i < seen.size(); ++i) ASSERT_EQ(seen[i], i);
    const auto points = inOrder(std::span<const Vec3>(set.points), tree.order());
    for (std::size_t i = 0; i < points.size(); ++i) ASSERT_EQ(points[i], tree.point(i));
  }
}

TEST(PhotonKdTree, FindsTheNearestOfBruteForce) {
  forEachQuery([&](const PhotonKdTree& tree, const test::PointSet&, const Vec3& p) {
    const std::vector<Neighbour> all = byDistance(tree, p);
    for (const std::size_t k : {1, 7, 50, 5000}) {
      std::vector<Neighbour> found(k);
      const std::size_t n = tree.nearest(p, found);
      ASSERT_EQ(n, std::min(k, all.size())) << "fewer only where there are fewer";
      found.resize(n);
      EXPECT_TRUE(std::is_heap(found.begin(), found.end()));
      std::sort(found.begin(), found.end());
      EXPECT_TRUE(std::equal(found.begin(), found.end(), all.begin())) << k;
    }
  });
}

TEST(PhotonKdTree, FindsTheNearestBelowARadius) {
  forEachQuery([&](const PhotonKdTree& tree, const test::PointSet& set, const Vec3& p) {
    const std::vector<Neighbour> all = byDistance(tree, p);
    for (const float radius : {0.f, 0.2f * set.size, set.size}) {
      std::vector<Neighbour> found(20);
      found.resize(tree.nearest(p, found, radius));
      std::sort(found.begin(), found.end());
      const auto below = std::count_if(all.begin(), all.end(), [&](const Neighbour& x) {
        return x.distance2() < radius * radius;
      });
      ASSERT_EQ(found.size(), std::min<std::size_t>(20, static_cast<std::size_t>(below)));
      EXPECT_TRUE(std::equal(found.begin(), found.end(), all.begin())) << radius;
    }
  });
}

TEST(PhotonKdTree, FindsAllWithinARadiusOnce) {
  forEachQuery([&](const PhotonKdTree& tree, const test::PointSet& set, const Vec3& p) {
    const std::vector<Neighbour> all = byDistance(tree, p);
    for (const float radius : {0.f, 1e-3f * set.size, 0.3f * set.size, 10 * set.size}) {
      std::vector<Neighbour> found;
      tree.forEachWithin(p, radius * radius,
                         [&](std::uint32_t i, float d2) { found.emplace_back(d2, i); });
      std::sort(found.begin(), found.end());
      const auto end = std::find_if(all.begin(), all.end(), [&](const Neighbour& x) {
        return !(x.distance2() < radius * radius);
      });
      EXPECT_TRUE(std::equal(found.begin(), found.end(), all.begin(), end)) << radius;
    }
  });
}

TEST(PhotonKdTree, LimitsTheWorkWhereAllPointsAreEqual) {
  // A search that visits every block would take minutes: 200,000 blocks for each of 10,000 queries.
  const std::vector<Vec3> points(1'600'000, Vec3(0.5f));
  const PhotonKdTree tree{std::span<const Vec3>(points)};
  std::vector<Neighbour> found(20);
  for (int i = 0; i < 10'000; ++i) {
    ASSERT_EQ(tree.nearest(Vec3(0.5f, 0.25f, 0), found), found.size());
    ASSERT_EQ(found.front().index(), 19u);
  }
}

TEST(PhotonKdTree, ReadsPointsOutOfLargerStructs) {
  struct Large {
    float before = 0;
    Vec3 p{0};
    double after = 0;
  };
  std::vector<Large> large(100);
  std::vector<Vec3> points(large.size());
  Rng rng(3);
  for (std::size_t i = 0; i < large.size(); ++i)
    large[i].p = points[i] = test::randomInBox(rng, Vec3(0), 1);
  const PhotonKdTree a(StridedPoints(&large[0].p, large.size(), sizeof(Large)));
  const PhotonKdTree b{std::span<const Vec3>(points)};
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(a.point(i), b.point(i));
}

TEST(PhotonKdTree, IsTheSameForAnyNumberOfThreads) {
  Rng rng(5);
  std::vector<Vec3> points(100'000);
  for (Vec3& p : points) p = test::randomInBox(rng, Vec3(0), 1);
  std::vector<std::vector<std::uint32_t>> orders;
  for (const int threads : {1, 2, 7}) {
    setThreadCount(threads);
    const PhotonKdTree tree{std::span<const Vec3>(points)};
    orders.emplace_back(tree.order().begin(), tree.order().end());
  }
  setThreadCount(0);
  EXPECT_EQ(orders[0], orders[1]);
  EXPECT_EQ(orders[0], orders[2]);
}

TEST(PhotonKdTree, RefusesPointsThatAreNotFinite) {
  for (const float bad : {kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN()}) {
    const std::vector<Vec3> points{Vec3(0), Vec3(0, bad, 0)};
    EXPECT_THROW(PhotonKdTree{std::span<const Vec3>(points)}, InternalError);
  }
}

TEST(PhotonKdTree, TakesSixteenBytesPerPoint) {
  Rng rng(6);
  std::vector<Vec3> points(100'000);
  for (Vec3& p : points) p = test::randomInBox(rng, Vec3(0), 1);
  const PhotonKdTree tree{std::span<const Vec3>(points)};
  EXPECT_LT(tree.memoryBytes(), 16 * points.size());
}

}  // namespace
}  // namespace brume
