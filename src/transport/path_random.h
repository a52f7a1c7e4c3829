// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "core/lowdiscrepancy.h"

namespace brume {

/// What the light paths of one pass share: the scrambles of their stratified numbers.
class PassRandom {
 public:
  /// Requests that are stratified: light, point, direction, time, first flight, first scattering.
  static constexpr std::uint32_t kStratified = 8;

  PassRandom(std::uint64_t seed, std::uint64_t pass);
  std::uint64_t key() const { return key_; }

  /// The stratified numbers of one path, by request.
  struct Points {
    alignas(32) std::array<float, kStratified> x, y;
  };
  /// Of neighbouring paths, several at once: one alone would wait for each of its multiplications.
  static constexpr std::uint32_t kAtOnce = 4;
  std::array<Points, kAtOnce> points(std::uint32_t firstPath) const;

 private:
  std::uint64_t key_;
  alignas(32) std::array<std::uint32_t, kStratified> order_, x_, y_;  // of Scramble
};

/// The random numbers of one light path: the first requests are Owen-scrambled (0,2)-sequences over
/// the paths of a pass, each with a scramble of its own, so that emission and first flight are
/// stratified; later ones are hashed. A function of (seed, pass, path, dimension) alone. Any prefix
/// of the paths, and any 2^k aligned ones, are stratified.
class PathRandom {
 public:
  /// points: the path's.
  PathRandom(const PassRandom& pass, std::uint32_t path, const PassRandom::Points& points)
      : points_(points), rng_(hashIntegers(pass.key(), path)) {}

  Vec2 get2D() {
    if (dimension_ >= PassRandom::kStratified) return rng_.uniform2();
    const std::uint32_t d = dimension_++;
    return {points_.x[d], points_.y[d]};
  }
  float get1D() {
    if (dimension_ >= PassRandom::kStratified) return rng_.uniform();
    return points_.x[dimension_++];
  }
  /// What the numbers beyond the stratified ones are hashed from.
  std::uint64_t key() const { return rng_.key(); }
  /// Any number of numbers that are none of those above.
  Rng apart() const { return Rng(rng_.key(), std::uint64_t{1} << 48); }

 private:
  const PassRandom::Points& points_;
  std::uint32_t dimension_ = 0;
  Rng rng_;
};

}  // namespace brume
