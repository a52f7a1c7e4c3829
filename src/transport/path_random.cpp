// SPDX-License-Identifier: Apache-2.0
#include "transport/path_random.h"

#include "core/lanes.h"

namespace brume {
namespace {

using Words = std::array<std::uint32_t, PassRandom::kStratified>;

struct Scrambles {
  const Words &order, &x, &y;
};

/// 24 bits as a number of [0, 1); by way of int, which vectors can convert.
inline float uniformOf(std::uint32_t bits) {
  return static_cast<float>(static_cast<std::int32_t>(bits >> 8)) * 0x1p-24f;
}

using PointsOfPaths = std::array<PassRandom::Points, PassRandom::kAtOnce>;

/// ScrambledSequence::point of some indices by all scrambles: straight loops that become vectors.
[[gnu::always_inline]] inline void fill(std::uint32_t firstPath, const Scrambles& scrambles,
                                        PointsOfPaths& paths) {
  for (PassRandom::Points& points : paths) {
    const std::uint32_t reversedPath = reverseBits(firstPath++);
    for (std::size_t d = 0; d < PassRandom::kStratified; ++d) {
      const std::uint32_t index = reverseBits(scrambleReversed(reversedPath, scrambles.order[d]));
      points.x[d] = uniformOf(reverseBits(scrambleReversed(index, scrambles.x[d])));
      points.y[d] =
          uniformOf(reverseBits(scrambleReversed(sobolSecondReversed(index), scrambles.y[d])));
    }
  }
}

#if BRUME_HAS_AVX2
BRUME_AVX2 void fillByAvx2(std::uint32_t firstPath, const Scrambles& scrambles,
                           PointsOfPaths& paths) {
  fill(firstPath, scrambles, paths);
}
#endif

}  // namespace

PassRandom::PassRandom(std::uint64_t seed, std::uint64_t pass)
    : key_(hashIntegers(seed, pass, 0x70686f746f6e73ull)) {
  for (std::uint32_t d = 0; d < kStratified; ++d) {
    const auto s = ScrambledSequence::Scramble::of(mixBits(key_ + 0x9e3779b97f4a7c15ull * (d + 1)));
    order_[d] = s.order;
    x_[d] = s.x;
    y_[d] = s.y;
  }
}

std::array<PassRandom::Points, PassRandom::kAtOnce> PassRandom::points(
    std::uint32_t firstPath) const {
  const Scrambles scrambles{order_, x_, y_};
  PointsOfPaths points;
#if BRUME_HAS_AVX2
  if (hasAvx2()) {
    fillByAvx2(firstPath, scrambles, points);
    return points;
  }
#endif
  fill(firstPath, scrambles, points);
  return points;
}

}  // namespace brume
