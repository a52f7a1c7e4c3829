// SPDX-License-Identifier: Apache-2.0
// Cosine and sine without branches, so that loops of them become vectors.
#pragma once

#include <cstdint>

#include "core/math.h"

namespace brume {

struct CosSin {
  float cosine, sine;
};

/// Of an angle in [-pi/4, pi/4], each in error by less than 1e-7: Taylor's series, whose next terms
/// are below 3e-8 there.
[[gnu::always_inline]] inline CosSin cosSinOfSmall(float x) {
  const float x2 = x * x;
  const float cosine =
      1.f + x2 * (-1.f / 2 + x2 * (1.f / 24 + x2 * (-1.f / 720 + x2 * (1.f / 40320))));
  const float sine =
      x * (1.f + x2 * (-1.f / 6 + x2 * (1.f / 120 + x2 * (-1.f / 5040 + x2 * (1.f / 362880)))));
  return {cosine, sine};
}

/// Of u turns, u in [0, 1], each in error by less than 1.5e-7.
[[gnu::always_inline]] inline CosSin cosSinOfTurn(float u) {
  // The rest of whole quarters, which is exact, lies within an eighth.
  const auto quarters = static_cast<std::int32_t>(4 * u + .5f);
  const CosSin small = cosSinOfSmall(2 * kPi * (u - .25f * static_cast<float>(quarters)));
  const bool isOdd = (quarters & 1) != 0, isHalfTurned = (quarters & 2) != 0;
  const float cosine = isOdd ? -small.sine : small.cosine, sine = isOdd ? small.cosine : small.sine;
  return {isHalfTurned ? -cosine : cosine, isHalfTurned ? -sine : sine};
}

}  // namespace brume
