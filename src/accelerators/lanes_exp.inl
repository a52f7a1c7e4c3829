// SPDX-License-Identifier: Apache-2.0
// The exponential of eight floats, included once for each kind of Lanes (lanes_math.h).

/// e^x with a relative error of 1e-7, for x <= 80; below -87 it is e^-87.
BRUME_KERNEL inline Lanes expOf(const Lanes& x) {
  // x = n ln 2 + f: adding 1.5 2^23 leaves n in the lowest bits.
  const Lanes bounded = max(Lanes::all(-87.f), x);
  const Lanes shift = Lanes::all(0x1.8p23f);
  const Lanes shifted = bounded * Lanes::all(0x1.715476p0f) + shift;
  const Lanes n = shifted - shift;
  const Lanes f = bounded - n * Lanes::all(0x1.62e4p-1f) - n * Lanes::all(0x1.7f7d1cp-20f);
  Lanes sum = Lanes::all(1.f / 5040);
  for (const float c : {1.f / 720, 1.f / 120, 1.f / 24, 1.f / 6, 0.5f, 1.f, 1.f})
    sum = sum * f + Lanes::all(c);
  return scaleByBits(sum, shifted);
}
