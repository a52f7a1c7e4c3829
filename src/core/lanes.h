// SPDX-License-Identifier: Apache-2.0
// Eight floats at once, chosen at run time: one binary runs everywhere and uses AVX2 where it is.
//
// A kernel is written once, in an .inl file, as functions marked BRUME_KERNEL that work with Lanes.
// A .cpp includes it twice, in namespaces of their own (both_lanes.inl): with `using namespace
// lanes_generic` and an empty BRUME_KERNEL, and with `using namespace lanes_avx2` and BRUME_KERNEL
// = BRUME_AVX2; it then calls one or the other by hasAvx2(). Both do the same operations in the
// same order, so they give the same bits. (Compiling a file with -mavx2 instead would let the
// linker choose AVX2 copies of inline functions for everyone; ifuncs do not work under sanitizers.)
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>

#if defined(__x86_64__)
#include <immintrin.h>
#define BRUME_HAS_AVX2 1
#define BRUME_AVX2 __attribute__((target("avx2,bmi,popcnt")))
#else
#define BRUME_HAS_AVX2 0
#endif

namespace brume {

inline constexpr std::size_t kLanes = 8;
/// Bit i speaks of lane i.
using LaneMask = std::uint32_t;

inline bool hasAvx2() {
#if BRUME_HAS_AVX2
  static const bool has = __builtin_cpu_supports("avx2") != 0 &&
                          __builtin_cpu_supports("bmi") != 0 &&
                          __builtin_cpu_supports("popcnt") != 0;
  return has;
#else
  return false;
#endif
}

namespace lanes_generic {

/// What eight numbers can do, whatever their type.
template <class T>
struct EightOf {
  std::array<T, kLanes> v;

  static EightOf all(T x) {
    EightOf r;
    r.v.fill(x);
    return r;
  }
  static EightOf load(const T* p) {
    EightOf r;
    std::copy_n(p, kLanes, r.v.begin());
    return r;
  }
  void store(T* p) const { std::copy_n(v.begin(), kLanes, p); }

  template <class Op>
  static EightOf each(const EightOf& a, const EightOf& b, Op op) {
    EightOf r;
    for (std::size_t i = 0; i < kLanes; ++i) r.v[i] = op(a.v[i], b.v[i]);
    return r;
  }
  template <class Op>
  static LaneMask compare(const EightOf& a, const EightOf& b, Op op) {
    LaneMask mask = 0;
    for (std::size_t i = 0; i < kLanes; ++i) mask |= LaneMask{op(a.v[i], b.v[i])} << i;
    return mask;
  }
  friend EightOf operator+(const EightOf& a, const EightOf& b) { return each(a, b, std::plus<>()); }
  friend EightOf operator-(const EightOf& a, const EightOf& b) {
    return each(a, b, std::minus<>());
  }
  friend EightOf operator*(const EightOf& a, const EightOf& b) {
    return each(a, b, std::multiplies<>());
  }
  /// The greater one; b when one of them is NaN.
  friend EightOf max(const EightOf& a, const EightOf& b) {
    return each(a, b, [](T x, T y) { return x > y ? x : y; });
  }
  /// The smaller one; b when one of them is NaN.
  friend EightOf min(const EightOf& a, const EightOf& b) {
    return each(a, b, [](T x, T y) { return x < y ? x : y; });
  }
  friend LaneMask less(const EightOf& a, const EightOf& b) { return compare(a, b, std::less<>()); }
  friend LaneMask lessEqual(const EightOf& a, const EightOf& b) {
    return compare(a, b, std::less_equal<>());
  }
};
using Lanes = EightOf<float>;

/// The lanes of the mask, moved together, stored from `to` on. Overwrites 8 places.
inline void compress(const Lanes& a, LaneMask mask, float* to) {
  for (; mask != 0; mask &= mask - 1) *to++ = a.v[static_cast<std::size_t>(std::countr_zero(mask))];
}
/// base + i for each lane i of the mask, stored likewise.
inline void compressIndices(std::uint32_t base, LaneMask mask, std::uint32_t* to) {
  for (; mask != 0; mask &= mask - 1)
    *to++ = base + static_cast<std::uint32_t>(std::countr_zero(mask));
}

}  // namespace lanes_generic

#if BRUME_HAS_AVX2
// Under the pragma GCC lays Lanes out as one register; without it copies go through memory in
// parts.
#if !defined(__clang__)
#pragma GCC push_options
#pragma GCC target("avx2,bmi,popcnt")
#endif
namespace lanes_avx2 {

/// For each mask the lanes of its bits in order, as 8 bytes.
inline constexpr std::array<std::uint64_t, 256> kCompressTable = [] {
  std::array<std::uint64_t, 256> table{};
  for (std::uint32_t mask = 0; mask < 256; ++mask)
    for (std::uint64_t lane = 0, n = 0; lane < 8; ++lane)
      if (mask >> lane & 1) table[mask] |= lane << (8 * n++);
  return table;
}();

struct Lanes {
  __m256 v;

  BRUME_AVX2 static Lanes all(float x) { return {_mm256_set1_ps(x)}; }
  BRUME_AVX2 static Lanes load(const float* p) { return {_mm256_loadu_ps(p)}; }
  BRUME_AVX2 void store(float* p) const { _mm256_storeu_ps(p, v); }
  BRUME_AVX2 friend Lanes operator+(const Lanes& a, const Lanes& b) {
    return {_mm256_add_ps(a.v, b.v)};
  }
  BRUME_AVX2 friend Lanes operator-(const Lanes& a, const Lanes& b) {
    return {_mm256_sub_ps(a.v, b.v)};
  }
  BRUME_AVX2 friend Lanes operator*(const Lanes& a, const Lanes& b) {
    return {_mm256_mul_ps(a.v, b.v)};
  }
  BRUME_AVX2 friend Lanes max(const Lanes& a, const Lanes& b) { return {_mm256_max_ps(a.v, b.v)}; }
  BRUME_AVX2 friend Lanes min(const Lanes& a, const Lanes& b) { return {_mm256_min_ps(a.v, b.v)}; }
  BRUME_AVX2 friend LaneMask less(const Lanes& a, const Lanes& b) {
    return static_cast<LaneMask>(_mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)));
  }
  BRUME_AVX2 friend LaneMask lessEqual(const Lanes& a, const Lanes& b) {
    return static_cast<LaneMask>(_mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)));
  }
};

BRUME_AVX2 inline __m256i lanesOf(LaneMask mask) {
  return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(kCompressTable[mask])));
}
BRUME_AVX2 inline void compress(const Lanes& a, LaneMask mask, float* to) {
  _mm256_storeu_ps(to, _mm256_permutevar8x32_ps(a.v, lanesOf(mask)));
}
BRUME_AVX2 inline void compressIndices(std::uint32_t base, LaneMask mask, std::uint32_t* to) {
  const __m256i indices =
      _mm256_add_epi32(_mm256_set1_epi32(static_cast<int>(base)), lanesOf(mask));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), indices);
}

}  // namespace lanes_avx2
#if !defined(__clang__)
#pragma GCC pop_options
#endif
#endif

}  // namespace brume
