// SPDX-License-Identifier: Apache-2.0
// Both kinds of lanes do the same, bit for bit.
#include "core/lanes_math.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/rng.h"

namespace brume {
namespace {

/// Everything that lanes can do with two rows of numbers.
struct Results {
  std::array<std::array<float, kLanes>, 12> values{};
  std::array<LaneMask, 2> masks{};
  std::array<float, 2 * kLanes> compressed{};
  std::array<std::uint32_t, 2 * kLanes> indices{};
};

/// Rows of four words, and which of them are wanted.
constexpr std::array<float, 4 * 5> kRows{0,  1,  2,  3,  10, 11, 12, 13, 20, 21,
                                         22, 23, 30, 31, 32, 33, 40, 41, 42, 43};
constexpr std::array<std::uint32_t, kLanes> kWanted{4, 0, 1, 3, 3, 2, 0, 4};

#define BRUME_LANES_RESULTS(kernel)                                                            \
  kernel Results results(const float* x, const float* y) {                                     \
    const Lanes a = Lanes::load(x), b = Lanes::load(y);                                        \
    Results r;                                                                                 \
    (a + b).store(r.values[0].data());                                                         \
    (a - b).store(r.values[1].data());                                                         \
    (a * b).store(r.values[2].data());                                                         \
    max(a, b).store(r.values[3].data());                                                       \
    Lanes::all(x[3]).store(r.values[4].data());                                                \
    withSign(a, b).store(r.values[5].data());                                                  \
    lowerHalf(a).store(r.values[6].data());                                                    \
    upperHalf(a).store(r.values[7].data());                                                    \
    const LaneColumns columns = gatherRows(kRows.data(), kWanted.data());                      \
    columns.c0.store(r.values[8].data());                                                      \
    columns.c1.store(r.values[9].data());                                                      \
    columns.c2.store(r.values[10].data());                                                     \
    columns.c3.store(r.values[11].data());                                                     \
    r.masks = {less(a, b), lessEqual(a, b)};                                                   \
    compress(a, r.masks[0], r.compressed.data());                                              \
    compressIndices(100, r.masks[0], r.indices.data());                                        \
    compressWords(kWanted.data(), r.masks[1], r.indices.data() + kLanes);                      \
    /* what stands behind the last is left open */                                             \
    for (std::size_t i = 0; i < kLanes; ++i) {                                                 \
      if (i >= static_cast<std::size_t>(std::popcount(r.masks[0])))                            \
        r.compressed[i] = 0, r.indices[i] = 0;                                                 \
      if (i >= static_cast<std::size_t>(std::popcount(r.masks[1]))) r.indices[kLanes + i] = 0; \
    }                                                                                          \
    return r;                                                                                  \
  }

namespace generic {
using namespace lanes_generic;
BRUME_LANES_RESULTS()
}  // namespace generic

#if BRUME_HAS_AVX2
namespace avx2 {
using namespace lanes_avx2;
BRUME_LANES_RESULTS(BRUME_AVX2)
}  // namespace avx2

TEST(Lanes, Avx2DoesTheSameAsPlainCode) {
  if (!hasAvx2()) GTEST_SKIP() << "this machine has no AVX2";
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kInf = std::numeric_limits<float>::infinity();
  const std::array<float, 8> special{0, -0.f, kInf, -kInf, kNan, 1e-44f, 3e38f, 1};
  Rng rng(1);
  for (int n = 0; n < 2000; ++n) {
    std::array<float, kLanes> x{}, y{};
    for (std::size_t i = 0; i < kLanes; ++i) {
      x[i] = rng.below(3) == 0 ? special[rng.below(8)] : rng.uniform() - 0.5f;
      y[i] = rng.below(3) == 0 ? x[i] : rng.below(3) == 0 ? special[rng.below(8)] : rng.uniform();
    }
    const Results a = generic::results(x.data(), y.data()), b = avx2::results(x.data(), y.data());
    EXPECT_EQ(a.masks, b.masks);
    EXPECT_EQ(a.indices, b.indices);
    for (std::size_t row = 0; row < a.values.size(); ++row)
      for (std::size_t i = 0; i < kLanes; ++i) {
        const float va = a.values[row][i], vb = b.values[row][i];
        EXPECT_TRUE(std::bit_cast<std::uint32_t>(va) == std::bit_cast<std::uint32_t>(vb) ||
                    (va != va && vb != vb))
            << row << ' ' << x[i] << ' ' << y[i];
      }
    for (std::size_t i = 0; i < 16; ++i)
      EXPECT_TRUE(a.compressed[i] == b.compressed[i] ||
                  (a.compressed[i] != a.compressed[i] && b.compressed[i] != b.compressed[i]));
  }
}
#endif

TEST(Lanes, PlainCodeCompresses) {
  std::array<float, kLanes> x{0, 1, 2, 3, 4, 5, 6, 7}, y{9, 0, 9, 0, 0, 9, 0, 9};
  const Results r = generic::results(x.data(), y.data());
  EXPECT_EQ(r.masks[0], 0b10100101u);
  EXPECT_EQ((std::vector<float>{r.compressed.begin(), r.compressed.begin() + 4}),
            (std::vector<float>{0, 2, 5, 7}));
  EXPECT_EQ((std::vector<std::uint32_t>{r.indices.begin(), r.indices.begin() + 4}),
            (std::vector<std::uint32_t>{100, 102, 105, 107}));
}

TEST(Lanes, PlainCodeGathersRows) {
  const std::array<float, kLanes> x{}, y{};
  const Results r = generic::results(x.data(), y.data());
  for (std::size_t i = 0; i < kLanes; ++i)
    for (std::size_t c = 0; c < 4; ++c) EXPECT_EQ(r.values[8 + c][i], kRows[4 * kWanted[i] + c]);
}

}  // namespace
}  // namespace brume
