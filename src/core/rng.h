// SPDX-License-Identifier: Apache-2.0
// Counter-based random numbers: a value is a pure function of (seed, pass, path, dimension), so any
// thread can compute any of them and the image does not depend on who did.
#pragma once

#include <cstdint>

#include "core/math.h"

namespace brume {

/// Bijective 64-bit finaliser (Stafford's mix 13, the one of SplitMix64).
constexpr std::uint64_t mixBits(std::uint64_t v) {
  v ^= v >> 30;
  v *= 0xbf58476d1ce4e5b9ull;
  v ^= v >> 27;
  v *= 0x94d049bb133111ebull;
  v ^= v >> 31;
  return v;
}

/// Hash of any number of integers; the order matters.
template <class... Ints>
constexpr std::uint64_t hashIntegers(Ints... values) {
  std::uint64_t h = 0x9e3779b97f4a7c15ull;
  ((h = mixBits(
        h ^ (static_cast<std::uint64_t>(values) + 0x9e3779b97f4a7c15ull + (h << 6) + (h >> 2)))),
   ...);
  return h;
}

/// Float in [0, 1) from the upper 24 of 32 random bits.
constexpr float uniformFloat(std::uint32_t bits) {
  return static_cast<float>(bits >> 8) * 0x1p-24f;
}

/// The random numbers of one path: dimension n is mix(key + n * golden ratio).
class Rng {
 public:
  constexpr Rng() = default;
  constexpr explicit Rng(std::uint64_t key, std::uint64_t dimension = 0)
      : key_(key), dimension_(dimension) {}
  static constexpr Rng forPath(std::uint64_t seed, std::uint64_t pass, std::uint64_t path) {
    return Rng(hashIntegers(seed, pass, path));
  }

  constexpr std::uint64_t bits64() { return mixBits(key_ + 0x9e3779b97f4a7c15ull * ++dimension_); }
  constexpr std::uint32_t bits32() { return static_cast<std::uint32_t>(bits64() >> 32); }
  /// Uniform in [0, 1).
  constexpr float uniform() { return uniformFloat(bits32()); }
  constexpr double uniformDouble() { return static_cast<double>(bits64() >> 11) * 0x1p-53; }
  Vec2 uniform2() {
    const std::uint64_t b = bits64();
    return {uniformFloat(static_cast<std::uint32_t>(b >> 32)),
            uniformFloat(static_cast<std::uint32_t>(b))};
  }
  /// Uniform integer in [0, n), n > 0.
  constexpr std::uint32_t below(std::uint32_t n) {
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(bits32()) * n) >> 32);
  }
  std::uint64_t key() const { return key_; }

 private:
  std::uint64_t key_ = 0;
  std::uint64_t dimension_ = 0;
};

}  // namespace brume
