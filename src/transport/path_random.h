// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/lowdiscrepancy.h"

namespace brume {

/// The random numbers of one light path: the first requests are Owen-scrambled (0,2)-sequences over
/// the paths of a pass, each with a scramble of its own, so that emission and first flight are
/// stratified; later ones are hashed. A function of (seed, pass, path, dimension) alone. Any prefix
/// of the paths, and any 2^k aligned ones, are stratified.
class PathRandom {
 public:
  /// Requests that are stratified: light, point, direction, time, first flight, first scattering.
  static constexpr std::uint32_t kStratified = 8;

  PathRandom(std::uint64_t passKey, std::uint32_t path)
      : passKey_(passKey), reversedPath_(reverseBits(path)), rng_(hashIntegers(passKey, path)) {}
  static std::uint64_t passKey(std::uint64_t seed, std::uint64_t pass) {
    return hashIntegers(seed, pass, 0x70686f746f6e73ull);
  }

  Vec2 get2D() {
    if (dimension_ >= kStratified) return rng_.uniform2();
    return ScrambledSequence::point(reversedPath_, nextScramble());
  }
  float get1D() {
    if (dimension_ >= kStratified) return rng_.uniform();
    return ScrambledSequence::point1D(reversedPath_, nextScramble());
  }
  /// Numbers beyond the stratified ones.
  Rng& hashed() { return rng_; }

 private:
  ScrambledSequence::Scramble nextScramble() {
    return ScrambledSequence::Scramble::of(
        mixBits(passKey_ + 0x9e3779b97f4a7c15ull * ++dimension_));
  }

  std::uint64_t passKey_;
  std::uint32_t reversedPath_;
  std::uint32_t dimension_ = 0;
  Rng rng_;
};

}  // namespace brume
