// SPDX-License-Identifier: Apache-2.0
// More of what eight floats can do: division, roots, exponentials, masks that stay vectors. The
// same bits in both kinds (lanes.h).
#pragma once

#include <cmath>

#include "core/lanes.h"

namespace brume {

namespace lanes_generic {

inline Lanes operator/(const Lanes& a, const Lanes& b) {
  return Lanes::each(a, b, std::divides<>());
}
inline Lanes sqrt(const Lanes& a) {
  return Lanes::each(a, a, [](float x, float) { return std::sqrt(x); });
}

/// A mask as a vector: all bits of a lane are equal.
inline Lanes fromBits(LaneMask mask) {
  Lanes r;
  for (std::size_t i = 0; i < kLanes; ++i)
    r.v[i] = std::bit_cast<float>(mask >> i & 1 ? 0xffffffffu : 0u);
  return r;
}
inline Lanes lessMask(const Lanes& a, const Lanes& b) { return fromBits(less(a, b)); }
inline Lanes lessEqualMask(const Lanes& a, const Lanes& b) { return fromBits(lessEqual(a, b)); }
inline Lanes operator&(const Lanes& a, const Lanes& b) {
  return Lanes::each(a, b, [](float x, float y) {
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(x) & std::bit_cast<std::uint32_t>(y));
  });
}
/// a in the lanes of a mask, b elsewhere.
inline Lanes select(const Lanes& mask, const Lanes& a, const Lanes& b) {
  Lanes r;
  for (std::size_t i = 0; i < kLanes; ++i)
    r.v[i] = std::bit_cast<std::uint32_t>(mask.v[i]) != 0 ? a.v[i] : b.v[i];
  return r;
}
inline LaneMask bitsOf(const Lanes& mask) {
  LaneMask bits = 0;
  for (std::size_t i = 0; i < kLanes; ++i)
    bits |= std::bit_cast<std::uint32_t>(mask.v[i]) >> 31 << i;
  return bits;
}
/// Adds 1 to the counts of the lanes of a mask.
inline void countLanes(const Lanes& mask, std::uint32_t* counts) {
  for (std::size_t i = 0; i < kLanes; ++i) counts[i] -= std::bit_cast<std::uint32_t>(mask.v[i]);
}
/// a 2^n, where n stands in the lowest bits of the float `shifted`; the result is a normal number.
inline Lanes scaleByBits(const Lanes& a, const Lanes& shifted) {
  return Lanes::each(a, shifted, [](float x, float n) {
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(x) +
                                (std::bit_cast<std::uint32_t>(n) << 23));
  });
}

/// Four words of each of eight rows: column c of row i stands in lane i of c_.
struct LaneColumns {
  Lanes c0, c1, c2, c3;
};
/// The rows of these indices; a row is four words, `rows` the first of row 0.
inline LaneColumns gatherRows(const float* rows, const std::uint32_t* indices) {
  LaneColumns r;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const float* row = rows + std::size_t{4} * indices[i];
    r.c0.v[i] = row[0], r.c1.v[i] = row[1], r.c2.v[i] = row[2], r.c3.v[i] = row[3];
  }
  return r;
}
/// The words of the lanes of the mask, moved together, stored from `to` on; `to` may be `from`, or
/// before. Overwrites 8 places.
inline void compressWords(const std::uint32_t* from, LaneMask mask, std::uint32_t* to) {
  for (; mask != 0; mask &= mask - 1) *to++ = from[std::countr_zero(mask)];
}
/// The lower and upper 16 bits of each lane, as numbers.
inline Lanes lowerHalf(const Lanes& bits) {
  return Lanes::each(bits, bits, [](float x, float) {
    return static_cast<float>(std::bit_cast<std::uint32_t>(x) & 0xffffu);
  });
}
inline Lanes upperHalf(const Lanes& bits) {
  return Lanes::each(bits, bits, [](float x, float) {
    return static_cast<float>(std::bit_cast<std::uint32_t>(x) >> 16);
  });
}
/// |a| with the sign of b.
inline Lanes withSign(const Lanes& a, const Lanes& b) {
  return Lanes::each(a, b, [](float x, float y) { return std::copysign(x, y); });
}

}  // namespace lanes_generic

#if BRUME_HAS_AVX2
// As in lanes.h: structs of Lanes as registers.
#if !defined(__clang__)
#pragma GCC push_options
#pragma GCC target("avx2,bmi,popcnt")
#endif
namespace lanes_avx2 {

BRUME_AVX2 inline Lanes operator/(const Lanes& a, const Lanes& b) {
  return {_mm256_div_ps(a.v, b.v)};
}
BRUME_AVX2 inline Lanes sqrt(const Lanes& a) { return {_mm256_sqrt_ps(a.v)}; }
BRUME_AVX2 inline Lanes lessMask(const Lanes& a, const Lanes& b) {
  return {_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)};
}
BRUME_AVX2 inline Lanes lessEqualMask(const Lanes& a, const Lanes& b) {
  return {_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)};
}
BRUME_AVX2 inline Lanes operator&(const Lanes& a, const Lanes& b) {
  return {_mm256_and_ps(a.v, b.v)};
}
BRUME_AVX2 inline Lanes select(const Lanes& mask, const Lanes& a, const Lanes& b) {
  return {_mm256_blendv_ps(b.v, a.v, mask.v)};
}
BRUME_AVX2 inline LaneMask bitsOf(const Lanes& mask) {
  return static_cast<LaneMask>(_mm256_movemask_ps(mask.v));
}
BRUME_AVX2 inline void countLanes(const Lanes& mask, std::uint32_t* counts) {
  auto* const to = reinterpret_cast<__m256i*>(counts);
  _mm256_storeu_si256(to, _mm256_sub_epi32(_mm256_loadu_si256(to), _mm256_castps_si256(mask.v)));
}
BRUME_AVX2 inline Lanes scaleByBits(const Lanes& a, const Lanes& shifted) {
  return {_mm256_castsi256_ps(_mm256_add_epi32(
      _mm256_castps_si256(a.v), _mm256_slli_epi32(_mm256_castps_si256(shifted.v), 23)))};
}

struct LaneColumns {
  Lanes c0, c1, c2, c3;
};
BRUME_AVX2 inline LaneColumns gatherRows(const float* rows, const std::uint32_t* indices) {
  // Rows i and i + 4 side by side, then two transpositions of 4 x 4 at once.
  const auto pair = [&](std::size_t i) BRUME_AVX2 {
    const __m128 lo = _mm_loadu_ps(rows + std::size_t{4} * indices[i]),
                 hi = _mm_loadu_ps(rows + std::size_t{4} * indices[i + 4]);
    return _mm256_insertf128_ps(_mm256_castps128_ps256(lo), hi, 1);
  };
  const __m256 r0 = pair(0), r1 = pair(1), r2 = pair(2), r3 = pair(3);
  const __m256 a = _mm256_unpacklo_ps(r0, r1), b = _mm256_unpackhi_ps(r0, r1),
               c = _mm256_unpacklo_ps(r2, r3), d = _mm256_unpackhi_ps(r2, r3);
  return {{_mm256_shuffle_ps(a, c, 0x44)},
          {_mm256_shuffle_ps(a, c, 0xee)},
          {_mm256_shuffle_ps(b, d, 0x44)},
          {_mm256_shuffle_ps(b, d, 0xee)}};
}
BRUME_AVX2 inline void compressWords(const std::uint32_t* from, LaneMask mask, std::uint32_t* to) {
  const __m256i words = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                      _mm256_permutevar8x32_epi32(words, lanesOf(mask)));
}
BRUME_AVX2 inline Lanes lowerHalf(const Lanes& bits) {
  return {
      _mm256_cvtepi32_ps(_mm256_and_si256(_mm256_castps_si256(bits.v), _mm256_set1_epi32(0xffff)))};
}
BRUME_AVX2 inline Lanes upperHalf(const Lanes& bits) {
  return {_mm256_cvtepi32_ps(_mm256_srli_epi32(_mm256_castps_si256(bits.v), 16))};
}
BRUME_AVX2 inline Lanes withSign(const Lanes& a, const Lanes& b) {
  const __m256 sign = _mm256_set1_ps(-0.f);
  return {_mm256_or_ps(_mm256_andnot_ps(sign, a.v), _mm256_and_ps(sign, b.v))};
}

}  // namespace lanes_avx2
#if !defined(__clang__)
#pragma GCC pop_options
#endif
#endif

}  // namespace brume
