// SPDX-License-Identifier: Apache-2.0
// Unit vectors on the octahedron |x| + |y| + |z| = 1, its lower half folded out: [-1, 1]^2 (Cigolle
// et al. 2014). Without branches, so that loops of them become vectors.
#pragma once

#include <cmath>
#include <cstdint>

namespace brume {

/// [-1, 1] to an even number of steps, so that 0 and +-1 are exact.
template <int kBits>
[[gnu::always_inline]] inline std::uint32_t quantise(float x) {
  constexpr float kHalf = static_cast<float>((1 << (kBits - 1)) - 1);
  const float above = x > -1.f ? x : -1.f, inside = above < 1.f ? above : 1.f;
  return static_cast<std::uint32_t>(static_cast<std::int32_t>((inside + 1) * kHalf + 0.5f));
}

/// The unit vector in twice so many bits, x below y.
template <int kBits>
[[gnu::always_inline]] inline std::uint32_t packOctahedron(float x, float y, float z) {
  const float scale = 1 / (std::abs(x) + std::abs(y) + std::abs(z));
  const float px = x * scale, py = y * scale;
  const float foldedX = std::copysign(1 - std::abs(py), px),
              foldedY = std::copysign(1 - std::abs(px), py);
  return quantise<kBits>(z >= 0 ? px : foldedX) | quantise<kBits>(z >= 0 ? py : foldedY) << kBits;
}

}  // namespace brume
