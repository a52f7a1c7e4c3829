// SPDX-License-Identifier: Apache-2.0
#include "accelerators/photon_ball.h"

#include <gtest/gtest.h>

#include "support/point_sets.h"

namespace brume {
namespace {

TEST(BallSearch, FindsTheDistanceOfBruteForce) {
  for (const test::PointSet& set : test::pointSets(1000)) {
    SCOPED_TRACE(set.name);
    const PhotonKdTree tree{std::span<const Vec3>(set.points)};
    Rng rng(1);
    BallSearch search;  // goes on from one place to quite another one
    for (int i = 0; i < 60; ++i) {
      const Vec3 p = test::randomInBox(rng, set.middle, set.size);
      const std::size_t k = 1 + rng.below(60);
      std::vector<Neighbour> found(k);
      const std::size_t n = tree.nearest(p, found);
      EXPECT_EQ(search.radius2OfNearest(tree, p, k), n > 0 ? found[0].distance2() : 0.f);
      // Not farther than a limit.
      const float limit = rng.uniform() * set.size;
      const std::size_t within = tree.nearest(p, found, limit);
      EXPECT_EQ(search.radius2OfNearest(tree, p, k, limit),
                within == k ? found[0].distance2() : limit * limit);
    }
  }
}

TEST(BallSearch, FindsAllNearerOnes) {
  for (const test::PointSet& set : test::pointSets(1000)) {
    SCOPED_TRACE(set.name);
    const PhotonKdTree tree{std::span<const Vec3>(set.points)};
    Rng rng(2);
    BallSearch search;
    for (int i = 0; i < 20; ++i) {
      const Vec3 p = test::randomInBox(rng, set.middle, set.size);
      const float radius2 = sqr(rng.uniform() * set.size);
      search.findWithin(tree, p, radius2);
      std::size_t expected = 0;
      tree.forEachWithin(p, radius2, [&](std::uint32_t, float) { ++expected; });
      EXPECT_EQ(search.size(), expected);
      for (std::size_t j = 0; j < search.size(); ++j) {
        const Vec3 d = tree.point(search.indices()[j]) - p;
        EXPECT_EQ(search.distances2()[j], d.x * d.x + d.y * d.y + d.z * d.z);
      }
    }
  }
}

}  // namespace
}  // namespace brume
