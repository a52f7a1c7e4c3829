// SPDX-License-Identifier: Apache-2.0
#include "transport/path_random.h"

#include <gtest/gtest.h>

namespace brume {
namespace {

TEST(PathRandom, StratifiedNumbersArePointsOfScrambledSequences) {
  const PassRandom pass(7, 11);
  for (std::uint32_t first = 0; first < 4096; first += PassRandom::kAtOnce) {
    const auto points = pass.points(first);
    for (std::uint32_t i = 0; i < PassRandom::kAtOnce; ++i) {
      PathRandom random(pass, first + i, points[i]);
      for (std::uint32_t d = 0; d < PassRandom::kStratified; ++d) {
        const auto scramble =
            ScrambledSequence::Scramble::of(mixBits(pass.key() + 0x9e3779b97f4a7c15ull * (d + 1)));
        const Vec2 expected = ScrambledSequence::point(reverseBits(first + i), scramble);
        if (d % 2 == 0)
          ASSERT_EQ(random.get2D(), expected);
        else
          ASSERT_EQ(random.get1D(), expected.x);
      }
    }
  }
}

TEST(PathRandom, LaterNumbersAreThoseOfThePath) {
  const PassRandom pass(7, 11), other(7, 12);
  const auto points = pass.points(0), otherPoints = other.points(0);
  const auto later = [](PathRandom random) {
    for (std::uint32_t d = 0; d < PassRandom::kStratified; ++d) random.get1D();
    return random.get2D();
  };
  const Vec2 u = later({pass, 0, points[0]});
  EXPECT_EQ(u, Rng(hashIntegers(pass.key(), 0)).uniform2());
  EXPECT_NE(u, later({pass, 1, points[1]}));
  EXPECT_NE(u, later({other, 0, otherPoints[0]}));
}

}  // namespace
}  // namespace brume
