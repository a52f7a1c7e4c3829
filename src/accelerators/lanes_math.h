// SPDX-License-Identifier: Apache-2.0
// More of what eight floats can do: division, roots, exponentials, masks that stay vectors. The
// same bits in both kinds (lanes.h).
#pragma once

#include <cmath>

#include "accelerators/lanes.h"

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

}  // namespace lanes_generic

#if BRUME_HAS_AVX2
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

}  // namespace lanes_avx2
#endif

}  // namespace brume
