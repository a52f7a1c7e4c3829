// SPDX-License-Identifier: Apache-2.0
#include "accelerators/photon_bvh.h"

#include <gtest/gtest.h>

#include "core/sampling.h"
#include "support/point_sets.h"

namespace brume {
namespace {

constexpr int kPoints = 3000, kBeams = 60;

struct Hit {
  std::uint32_t index;
  float t, d2;
  friend bool operator==(const Hit&, const Hit&) = default;
  friend bool operator<(const Hit& a, const Hit& b) { return a.index < b.index; }
};

std::vector<Hit> bruteForce(const PhotonKdTree& tree, const PhotonBvh& bvh, const BeamQuery& beam) {
  std::vector<Hit> hits;
  for (std::uint32_t i = 0; i < tree.size(); ++i) {
    const auto foot = beamFoot(beam.o, beam.d, tree.point(i));
    if (isInBeam(foot, beam.range, bvh.radius2(i))) hits.push_back({i, foot.t, foot.d2});
  }
  return hits;
}

std::vector<Hit> query(const PhotonBvh& bvh, const BeamQuery& beam) {
  std::vector<Hit> hits;
  bvh.forEachInBeam(beam, [&](std::uint32_t i, const BeamFoot<float>& foot) {
    hits.push_back({i, foot.t, foot.d2});
  });
  std::sort(hits.begin(), hits.end());
  return hits;
}

/// Beams near the points: from outside, from within, from a point, along an axis, of no length.
BeamQuery someBeam(Rng& rng, const PhotonKdTree& tree, const test::PointSet& set, int i) {
  const auto somePoint = [&] {
    return tree.size() > 0 ? tree.point(rng.below(static_cast<std::uint32_t>(tree.size())))
                           : set.middle;
  };
  BeamQuery beam;
  beam.o = test::randomInBox(rng, set.middle, 3 * set.size);
  const Vec3 target =
      rng.below(2) != 0 ? somePoint() : test::randomInBox(rng, set.middle, set.size);
  beam.d = tryNormalize(target - beam.o).value_or(Vec3(0, 1, 0));
  beam.range = {0, kInfinity};
  switch (i % 6) {
    case 0:
      beam.range.t1 = distance(beam.o, target);
      break;  // ends at a point
    case 1:
      beam.range = {set.size, 2 * set.size};
      break;
    case 2:
      beam.o = somePoint();
      break;
    case 3:
      beam.o = somePoint();
      beam.d = Vec3(0);
      beam.d[static_cast<int>(rng.below(3))] = rng.below(2) != 0 ? 1.f : -1.f;
      beam.range = {-2 * set.size, 2 * set.size};
      break;
    case 4:
      beam.o = somePoint();
      beam.range = {0, 0};
      break;
    default:
      break;
  }
  return beam;
}

template <class MakeBvh>
void expectBruteForce(MakeBvh&& makeBvh) {
  std::size_t total = 0;
  for (const test::PointSet& set : test::pointSets(kPoints)) {
    SCOPED_TRACE(set.name);
    const PhotonKdTree tree{std::span<const Vec3>(set.points)};
    const PhotonBvh bvh = makeBvh(tree, set);
    Rng rng(11);
    for (int i = 0; i < kBeams; ++i) {
      const BeamQuery beam = someBeam(rng, tree, set, i);
      const std::vector<Hit> expected = bruteForce(tree, bvh, beam);
      EXPECT_EQ(query(bvh, beam), expected) << "beam " << i;
      total += expected.size();
    }
  }
  EXPECT_GT(total, 1000u) << "the beams meet photons";
}

TEST(PhotonBvh, FindsTheBeamsOfBruteForceWithOneRadius) {
  for (const float radius : {1e-4f, 0.03f, 0.3f, 5.f})
    expectBruteForce([&](const PhotonKdTree& tree, const test::PointSet& set) {
      return PhotonBvh(tree, radius * set.size);
    });
}

TEST(PhotonBvh, FindsTheBeamsOfBruteForceWithARadiusEach) {
  expectBruteForce([](const PhotonKdTree& tree, const test::PointSet& set) {
    Rng rng(12);
    std::vector<float> radii2;
    for (std::size_t i = 0; i < tree.size(); ++i)
      radii2.push_back(rng.below(10) == 0 ? 0.f
                                          : sqr(set.size * std::pow(10.f, -3 * rng.uniform())));
    return PhotonBvh(tree, radii2);
  });
}

TEST(PhotonBvh, FindsTheBeamsOfBruteForceWithAdaptiveRadii) {
  expectBruteForce([](const PhotonKdTree& tree, const test::PointSet&) {
    return PhotonBvh(tree, adaptiveRadii2(tree, 20));
  });
}

TEST(PhotonBvh, FindsNothingWithRadiusZero) {
  const std::vector<Vec3> points(20, Vec3(0, 0, 1));
  const PhotonKdTree tree{std::span<const Vec3>(points)};
  EXPECT_TRUE(query(PhotonBvh(tree, 0.f), {Vec3(0), Vec3(0, 0, 1), {0, 2}}).empty());
}

TEST(PhotonBvh, CountsNoPhotonBehindTheEnd) {
  const std::vector<Vec3> points{Vec3(0, 0, 1), Vec3(0.1f, 0, 2), Vec3(0, 0, 3)};
  const PhotonKdTree tree{std::span<const Vec3>(points)};
  const PhotonBvh bvh(tree, 1.f);
  const auto count = [&](Interval range) {
    return query(bvh, {Vec3(0), Vec3(0, 0, 1), range}).size();
  };
  EXPECT_EQ(count({0, 1.999f}), 1u);
  EXPECT_EQ(count({0, 2}), 2u) << "the range is closed";
  EXPECT_EQ(count({2, 3}), 2u);
  EXPECT_EQ(count({2.001f, 2.999f}), 0u);
  EXPECT_EQ(count({0, kInfinity}), 3u);
}

TEST(AdaptiveRadii, FollowTheLawOfSpace) {
  // In a uniform density D the ball with k points has the radius (3 k / (4 pi D))^(1/3).
  constexpr int kN = 100'000;
  Rng rng(13);
  std::vector<Vec3> points(kN);
  for (Vec3& p : points) p = test::randomInBox(rng, Vec3(0), 0.5f);
  const PhotonKdTree tree{std::span<const Vec3>(points)};
  const std::vector<float> radii2 = adaptiveRadii2(tree, 40);
  const float expected = std::cbrt(3 * 40 / (4 * kPi * kN));
  double sum = 0;
  int inside = 0;
  for (std::size_t i = 0; i < radii2.size(); ++i) {
    if (maxComponent(abs(tree.point(i))) > 0.5f - 1.5f * expected) continue;  // its ball is cut
    sum += std::sqrt(radii2[i]);
    ++inside;
    // 40 points: radii scatter by 1/(3 sqrt(40)) = 5 %; 6 times that is never seen.
    EXPECT_NEAR(std::sqrt(radii2[i]) / expected, 1, 0.32);
  }
  // The middle of a block is not a random place: its own 8 points are nearer to it.
  EXPECT_NEAR(sum / inside / double{expected}, 1, 0.03);
}

TEST(AdaptiveRadii, AreNeverZeroAndGrowWherePhotonsAreFew) {
  const std::vector<Vec3> equal(100, Vec3(3, 0, 0));
  for (const float r2 : adaptiveRadii2(PhotonKdTree{std::span<const Vec3>(equal)}, 10))
    EXPECT_GT(r2, 0);
  // Two photons, two apart, 16 asked: the ball around their middle has radius 1, and 16/2 = 2^3.
  const std::vector<Vec3> two{Vec3(-1, 0, 0), Vec3(1, 0, 0)};
  for (const float r2 : adaptiveRadii2(PhotonKdTree{std::span<const Vec3>(two)}, 16))
    EXPECT_NEAR(r2, 4, 1e-5);
}

TEST(AdaptiveRadii, AreTheSameForAnyNumberOfThreads) {
  Rng rng(14);
  std::vector<Vec3> points(20'000);
  for (Vec3& p : points) p = test::randomInBox(rng, Vec3(0), 1);
  const PhotonKdTree tree{std::span<const Vec3>(points)};
  std::vector<std::vector<float>> radii2;
  for (const int threads : {1, 2, 7}) {
    setThreadCount(threads);
    radii2.push_back(adaptiveRadii2(tree, 20));
  }
  setThreadCount(0);
  EXPECT_EQ(radii2[0], radii2[1]);
  EXPECT_EQ(radii2[0], radii2[2]);
}

}  // namespace
}  // namespace brume
