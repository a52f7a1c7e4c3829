// SPDX-License-Identifier: Apache-2.0
// Eight doubles at once, beside the eight floats of lanes.h: for positions, whose differences
// matter. The same bits in both kinds.
#pragma once

#include <cmath>

#include "core/lanes_math.h"

namespace brume {

namespace lanes_generic {

using Doubles = EightOf<double>;

/// As whole numbers, which they are: 0 <= x < 2^51.
inline void storeIndices(const Doubles& a, std::int64_t* p) {
  for (std::size_t i = 0; i < kLanes; ++i) p[i] = static_cast<std::int64_t>(a.v[i]);
}
inline Doubles floor(const Doubles& a) {
  return Doubles::each(a, a, [](double x, double) { return std::floor(x); });
}
inline Doubles widen(const Lanes& a) {
  Doubles r;
  for (std::size_t i = 0; i < kLanes; ++i) r.v[i] = double{a.v[i]};
  return r;
}
inline Lanes narrow(const Doubles& a) {
  Lanes r;
  for (std::size_t i = 0; i < kLanes; ++i) r.v[i] = static_cast<float>(a.v[i]);
  return r;
}

/// Pairs of neighbours: the first in `low`, the second in `high`.
struct LanePairs {
  Lanes low, high;
};
/// from[indices[i]] and from[indices[i] + 1].
inline LanePairs gatherPairs(const float* from, const std::int64_t* indices) {
  LanePairs r;
  for (std::size_t i = 0; i < kLanes; ++i) {
    r.low.v[i] = from[indices[i]];
    r.high.v[i] = from[indices[i] + 1];
  }
  return r;
}

}  // namespace lanes_generic

#if BRUME_HAS_AVX2
// As in lanes.h: structs of vectors as registers.
#if !defined(__clang__)
#pragma GCC push_options
#pragma GCC target("avx2,bmi,popcnt")
#endif
namespace lanes_avx2 {

struct Doubles {
  __m256d lo, hi;

  BRUME_AVX2 static Doubles all(double x) { return {_mm256_set1_pd(x), _mm256_set1_pd(x)}; }
  BRUME_AVX2 static Doubles load(const double* p) {
    return {_mm256_loadu_pd(p), _mm256_loadu_pd(p + 4)};
  }
  BRUME_AVX2 void store(double* p) const {
    _mm256_storeu_pd(p, lo);
    _mm256_storeu_pd(p + 4, hi);
  }
  BRUME_AVX2 friend Doubles operator+(const Doubles& a, const Doubles& b) {
    return {_mm256_add_pd(a.lo, b.lo), _mm256_add_pd(a.hi, b.hi)};
  }
  BRUME_AVX2 friend Doubles operator-(const Doubles& a, const Doubles& b) {
    return {_mm256_sub_pd(a.lo, b.lo), _mm256_sub_pd(a.hi, b.hi)};
  }
  BRUME_AVX2 friend Doubles operator*(const Doubles& a, const Doubles& b) {
    return {_mm256_mul_pd(a.lo, b.lo), _mm256_mul_pd(a.hi, b.hi)};
  }
  BRUME_AVX2 friend Doubles max(const Doubles& a, const Doubles& b) {
    return {_mm256_max_pd(a.lo, b.lo), _mm256_max_pd(a.hi, b.hi)};
  }
  BRUME_AVX2 friend Doubles min(const Doubles& a, const Doubles& b) {
    return {_mm256_min_pd(a.lo, b.lo), _mm256_min_pd(a.hi, b.hi)};
  }
};

BRUME_AVX2 inline void storeIndices(const Doubles& a, std::int64_t* p) {
  // From 2^52 on the last bit of a double is worth 1.
  const __m256d shift = _mm256_set1_pd(0x1p52);
  auto* const to = reinterpret_cast<double*>(p);
  _mm256_storeu_pd(to, _mm256_xor_pd(_mm256_add_pd(a.lo, shift), shift));
  _mm256_storeu_pd(to + 4, _mm256_xor_pd(_mm256_add_pd(a.hi, shift), shift));
}
BRUME_AVX2 inline Doubles floor(const Doubles& a) {
  return {_mm256_floor_pd(a.lo), _mm256_floor_pd(a.hi)};
}
BRUME_AVX2 inline Doubles widen(const Lanes& a) {
  return {_mm256_cvtps_pd(_mm256_castps256_ps128(a.v)),
          _mm256_cvtps_pd(_mm256_extractf128_ps(a.v, 1))};
}
BRUME_AVX2 inline Lanes narrow(const Doubles& a) {
  return {_mm256_insertf128_ps(_mm256_castps128_ps256(_mm256_cvtpd_ps(a.lo)), _mm256_cvtpd_ps(a.hi),
                               1)};
}

struct LanePairs {
  Lanes low, high;
};
BRUME_AVX2 inline LanePairs gatherPairs(const float* from, const std::int64_t* indices) {
  // Lanes 0 1 4 5 and 2 3 6 7 side by side, so that one shuffle puts all in order.
  const auto four = [&](std::size_t i) BRUME_AVX2 {
    const auto at = [&](std::size_t k)
                        BRUME_AVX2 { return reinterpret_cast<const double*>(from + indices[k]); };
    const __m128d a = _mm_loadh_pd(_mm_load_sd(at(i)), at(i + 1)),
                  b = _mm_loadh_pd(_mm_load_sd(at(i + 4)), at(i + 5));
    return _mm256_castpd_ps(_mm256_insertf128_pd(_mm256_castpd128_pd256(a), b, 1));
  };
  const __m256 a = four(0), b = four(2);
  return {{_mm256_shuffle_ps(a, b, 0x88)}, {_mm256_shuffle_ps(a, b, 0xdd)}};
}

}  // namespace lanes_avx2
#if !defined(__clang__)
#pragma GCC pop_options
#endif
#endif

}  // namespace brume
