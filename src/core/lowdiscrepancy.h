// SPDX-License-Identifier: Apache-2.0
// Low-discrepancy sequences, and the sample stream that most samplers share: padded (0,2)-sequences
// with Owen scrambling.
#pragma once

#include <bit>

#include "core/rng.h"
#include "core/sampler.h"

namespace brume {

constexpr std::uint32_t reverseBits(std::uint32_t v) {
  v = ((v & 0x55555555u) << 1) | ((v >> 1) & 0x55555555u);
  v = ((v & 0x33333333u) << 2) | ((v >> 2) & 0x33333333u);
  v = ((v & 0x0f0f0f0fu) << 4) | ((v >> 4) & 0x0f0f0f0fu);
  return __builtin_bswap32(v);
}

/// Owen's nested uniform scramble of a number whose bits are reversed: each bit flips by a hash of
/// the bits below it. Source: Laine, Karras 2011, with the constants of Vegdahl 2021.
constexpr std::uint32_t scrambleReversed(std::uint32_t v, std::uint32_t seed) {
  v ^= v * 0x3d20adeau;
  v += seed;
  v *= (seed >> 16) | 1u;
  v ^= v * 0x05526c56u;
  v ^= v * 0x53a22864u;
  return v;
}

/// Second coordinate of Sobol's (0,2)-sequence, its bits reversed (the first coordinate's are the
/// index itself). The generator is Pascal's triangle mod 2, so bit r is the exclusive or of the
/// index bits at all supersets of r (Lucas), found in five steps.
constexpr std::uint32_t sobolSecondReversed(std::uint32_t index) {
  index ^= (index >> 1) & 0x55555555u;
  index ^= (index >> 2) & 0x33333333u;
  index ^= (index >> 4) & 0x0f0f0f0fu;
  index ^= (index >> 8) & 0x00ff00ffu;
  return index ^ ((index >> 16) & 0x0000ffffu);
}

/// Radical inverse of the index in a base, its digits rotated by those of a random fraction
/// (digital shift): keeps every elementary interval property of the sequence.
float shiftedRadicalInverse(std::uint32_t base, std::uint32_t index, std::uint32_t random);

/// Element i of a random permutation of [0, n), i < n. Source: Kensler 2013, Correlated
/// Multi-Jittered Sampling.
std::uint32_t permutedIndex(std::uint32_t i, std::uint32_t n, std::uint32_t seed);

/// The sample of the unit square u in a pixel; the result stays inside although it is rounded.
inline Vec2 positionInPixel(Vec2i pixel, Vec2 u) {
  const auto place = [](int p, float x) {
    const float lo = static_cast<float>(p), v = lo + x;
    return v < lo + 1.f ? v : std::nextafter(lo + 1.f, lo);
  };
  return {place(pixel.x, u.x), place(pixel.y, u.y)};
}

/// Smallest power of two >= n, for 1 <= n <= 2^30.
inline int roundUpToPowerOfTwo(int n) {
  return static_cast<int>(std::bit_ceil(static_cast<std::uint32_t>(n)));
}

/// Sample dimensions as independent (0,2)-sequences over the samples of one pixel: each request of
/// a path is one dimension with its own Owen scramble and its own order of the points, so pairs of
/// dimensions are uncorrelated, while any 2^k aligned samples are stratified in every elementary
/// interval of each. Everything depends on (key of the pixel, dimension, sample index) only. After
/// kSequenceDimensions requests the values are hashed: deep bounces gain nothing from
/// stratification. Source: Burley 2020, Practical Hash-based Owen Scrambling.
class ScrambledSequence : public PixelSampler {
 public:
  static constexpr std::uint32_t kSequenceDimensions = 32;

  /// The random numbers behind one dimension: for the order of its points, and for either axis.
  struct Scramble {
    std::uint32_t order, x, y;
    /// From 64 random bits.
    static Scramble of(std::uint64_t bits);
  };
  /// The point of a dimension with the given bit-reversed index.
  static Vec2 point(std::uint32_t reversedIndex, const Scramble& scramble);
  /// Its first coordinate alone.
  static float point1D(std::uint32_t reversedIndex, const Scramble& scramble);

  float get1D() final;
  Vec2 get2D() final;
  float getShift() final;
  void get1DArray(std::span<float> values) final;
  void get2DArray(std::span<Vec2> values) final;

 protected:
  /// Starts a pixel (or a new, independent round of its samples).
  void setPixelKey(std::uint64_t key) { pixelKey_ = key; }
  std::uint64_t pixelKey() const { return pixelKey_; }
  /// Starts a sample; dimensions count from 0 again.
  void setSample(std::uint32_t index) {
    index_ = index;
    reversedIndex_ = reverseBits(index);
    dimension_ = 0;
  }
  std::uint32_t sampleIndex() const { return index_; }

 private:
  Scramble nextScramble();
  Vec2 hashed(std::uint32_t index, const Scramble& scramble) const;

  std::uint64_t pixelKey_ = 0;
  std::uint32_t index_ = 0, reversedIndex_ = 0, dimension_ = 0;
};

}  // namespace brume
