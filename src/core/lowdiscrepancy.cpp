// SPDX-License-Identifier: Apache-2.0
#include "core/lowdiscrepancy.h"

namespace brume {

float shiftedRadicalInverse(std::uint32_t base, std::uint32_t index, std::uint32_t random) {
  // Digits of the index from the lowest, each rotated; until a float cannot hold more.
  const double inverseBase = 1.0 / base;
  double value = 0, weight = inverseBase;
  for (; weight > 0x1p-32; weight *= inverseBase) {
    // The next digit of the random fraction is the integer part of its product with the base.
    const std::uint64_t product = std::uint64_t{random} * base;
    random = static_cast<std::uint32_t>(product);
    std::uint32_t digit = index % base + static_cast<std::uint32_t>(product >> 32);
    if (digit >= base) digit -= base;
    index /= base;
    value += digit * weight;
  }
  return std::min(static_cast<float>(value), kOneMinusEpsilon);
}

std::uint32_t permutedIndex(std::uint32_t i, std::uint32_t n, std::uint32_t seed) {
  if (n <= 1) return 0;
  const std::uint32_t w = std::bit_ceil(n) - 1;
  // A hash that is a bijection of [0, w], repeated until it falls into [0, n).
  do {
    i ^= seed;
    i *= 0xe170893du;
    i ^= seed >> 16;
    i ^= (i & w) >> 4;
    i ^= seed >> 8;
    i *= 0x0929eb3fu;
    i ^= seed >> 23;
    i ^= (i & w) >> 1;
    i *= 1u | seed >> 27;
    i *= 0x6935fa69u;
    i ^= (i & w) >> 11;
    i *= 0x74dcb303u;
    i ^= (i & w) >> 2;
    i *= 0x9e501cc3u;
    i ^= (i & w) >> 2;
    i *= 0xc860a3dfu;
    i &= w;
    i ^= i >> 5;
  } while (i >= n);
  return static_cast<std::uint32_t>((static_cast<std::uint64_t>(i) + seed) % n);
}

ScrambledSequence::Scramble ScrambledSequence::nextScramble() {
  return Scramble::of(mixBits(pixelKey_ + 0x9e3779b97f4a7c15ull * ++dimension_));
}

ScrambledSequence::Scramble ScrambledSequence::Scramble::of(std::uint64_t bits) {
  const auto low = static_cast<std::uint32_t>(bits), high = static_cast<std::uint32_t>(bits >> 32);
  // The third number need only differ from the other two: its bits meet other hash steps.
  return {low, high, (low ^ std::rotl(high, 13)) * 0x9e3779b9u};
}

Vec2 ScrambledSequence::hashed(std::uint32_t index, const Scramble& s) const {
  const std::uint64_t h =
      mixBits(((std::uint64_t{s.x} << 32) | s.order) + 0xd1b54a32d192ed03ull * index);
  return {uniformFloat(static_cast<std::uint32_t>(h >> 32)),
          uniformFloat(static_cast<std::uint32_t>(h))};
}

Vec2 ScrambledSequence::point(std::uint32_t reversedIndex, const Scramble& s) {
  const std::uint32_t index = reverseBits(scrambleReversed(reversedIndex, s.order));
  return {uniformFloat(reverseBits(scrambleReversed(index, s.x))),
          uniformFloat(reverseBits(scrambleReversed(sobolSecondReversed(index), s.y)))};
}

float ScrambledSequence::point1D(std::uint32_t reversedIndex, const Scramble& s) {
  const std::uint32_t index = reverseBits(scrambleReversed(reversedIndex, s.order));
  return uniformFloat(reverseBits(scrambleReversed(index, s.x)));
}

float ScrambledSequence::get1D() {
  const Scramble s = nextScramble();
  if (dimension_ > kSequenceDimensions) return hashed(index_, s).x;
  return point1D(reversedIndex_, s);
}

float ScrambledSequence::getShift() {
  // Van der Corput's sequence in an order of its own, turned on the circle.
  const Scramble s = nextScramble();
  return uniformFloat(scrambleReversed(reversedIndex_, s.order) + s.x);
}

Vec2 ScrambledSequence::get2D() {
  const Scramble s = nextScramble();
  return dimension_ > kSequenceDimensions ? hashed(index_, s) : point(reversedIndex_, s);
}

void ScrambledSequence::get1DArray(std::span<float> values) {
  const Scramble s = nextScramble();
  const bool stratified = dimension_ <= kSequenceDimensions;
  std::uint32_t i = index_ * static_cast<std::uint32_t>(values.size());
  for (float& value : values) {
    value = stratified ? point(reverseBits(i), s).x : hashed(i, s).x;
    ++i;
  }
}

void ScrambledSequence::get2DArray(std::span<Vec2> values) {
  const Scramble s = nextScramble();
  const bool stratified = dimension_ <= kSequenceDimensions;
  std::uint32_t i = index_ * static_cast<std::uint32_t>(values.size());
  for (Vec2& value : values) {
    value = stratified ? point(reverseBits(i), s) : hashed(i, s);
    ++i;
  }
}

}  // namespace brume
