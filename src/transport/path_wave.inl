// SPDX-License-Identifier: Apache-2.0
// The vector loops of PathWave, included once for each kind of Lanes (lanes.h): plain loops without
// branches, which the compiler turns into vectors.

/// 24 bits as a number of [0, 1); by way of int, which vectors can convert.
[[gnu::always_inline]] inline BRUME_KERNEL float uniformOf(std::uint32_t bits) {
  return static_cast<float>(static_cast<std::int32_t>(bits >> 8)) * 0x1p-24f;
}

BRUME_KERNEL void drawNumbers(std::uint64_t dimension, PathWave& wave) {
  constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15ull;  // of Rng, from dimension to dimension
  const std::uint64_t first = kStep * (dimension + 1);
  for (std::size_t i = 0, n = wave.lanes(); i < n; ++i) {
    const std::uint64_t key = (std::uint64_t{wave.keyHigh[i]} << 32 | wave.keyLow[i]) + first;
    const std::uint64_t flight = mixBits(key), u1 = mixBits(key + kStep),
                        u2 = mixBits(key + 2 * kStep), direction = mixBits(key + 3 * kStep);
    wave.uChannel[i] = uniformOf(static_cast<std::uint32_t>(flight >> 32));
    wave.uDepth[i] = uniformOf(static_cast<std::uint32_t>(flight));
    wave.u1[i] = uniformOf(static_cast<std::uint32_t>(u1 >> 32));
    wave.u2[i] = uniformOf(static_cast<std::uint32_t>(u2 >> 32));
    wave.ux[i] = uniformOf(static_cast<std::uint32_t>(direction >> 32));
    wave.uy[i] = uniformOf(static_cast<std::uint32_t>(direction));
  }
}

[[gnu::always_inline]] inline BRUME_KERNEL void compressArray(PathWave::Words& words,
                                                              std::size_t from, LaneMask mask,
                                                              std::size_t to) {
  compressWords(&words[from], mask, &words[to]);
}
[[gnu::always_inline]] inline BRUME_KERNEL void compressArray(PathWave::Floats& floats,
                                                              std::size_t from, LaneMask mask,
                                                              std::size_t to) {
  compress(Lanes::load(&floats[from]), mask, &floats[to]);
}

BRUME_KERNEL void dropEnded(PathWave& wave) {
  for (std::size_t i = 0, n = wave.lanes(); i < n; ++i) {
    const float isAlive = wave.isAlive[i];
    wave.isAlive[i] = (wave.canStore[i] & wave.wanted[i]) != 0 ? isAlive : 0.f;
  }
  std::size_t to = 0;
  for (std::size_t i = 0; i < wave.count; i += kLanes) {
    LaneMask mask = less(Lanes::all(0), Lanes::load(&wave.isAlive[i]));
    if (wave.count - i < kLanes) mask &= (1u << (wave.count - i)) - 1;
    const auto move = [&](auto&... arrays)
                          BRUME_KERNEL { (compressArray(arrays, i, mask, to), ...); };
    move(wave.o.x, wave.o.y, wave.o.z, wave.d.x, wave.d.y, wave.d.z, wave.time, wave.power.r,
         wave.power.g, wave.power.b, wave.usualPower, wave.canStore, wave.isInMedium, wave.wanted,
         wave.path, wave.keyLow, wave.keyHigh);
    to += static_cast<std::size_t>(std::popcount(mask));
  }
  wave.count = to;
  std::fill_n(wave.isAlive.begin(), wave.lanes(), 1.f);
}

/// The part of a ray between two faces of a box, widened by what rounding may do to it (Ize 2013).
struct SlabEnds {
  float enter, leave;
};
[[gnu::always_inline]] inline BRUME_KERNEL SlabEnds slabEnds(float o, float d, float lo, float hi) {
  constexpr float kRounding = 0x1p-20f;
  const float absO = std::abs(o), inverse = 1 / d;
  const float toLo = (lo - kRounding * (std::abs(lo) + absO) - o) * inverse,
              toHi = (hi + kRounding * (std::abs(hi) + absO) - o) * inverse;
  return {(inverse > 0 ? toLo : toHi) * (1 - kRounding),
          (inverse > 0 ? toHi : toLo) * (1 + kRounding)};
}

BRUME_KERNEL void findSegmentsNear(const Bounds3& surfaces, PathWave& wave) {
  const float lowX = surfaces.lo.x, lowY = surfaces.lo.y, lowZ = surfaces.lo.z;
  const float highX = surfaces.hi.x, highY = surfaces.hi.y, highZ = surfaces.hi.z;
  for (std::size_t i = 0, n = wave.lanes(); i < n; ++i) {
    const SlabEnds x = slabEnds(wave.o.x[i], wave.d.x[i], lowX, highX),
                   y = slabEnds(wave.o.y[i], wave.d.y[i], lowY, highY),
                   z = slabEnds(wave.o.z[i], wave.d.z[i], lowZ, highZ);
    // 0 times infinity, in the plane of a face, fails all comparisons and bounds nothing.
    const float t = wave.t[i] * (1 + 0x1p-20f);
    const float leaveX = x.leave < t ? x.leave : t, leaveXY = y.leave < leaveX ? y.leave : leaveX,
                leave = z.leave < leaveXY ? z.leave : leaveXY;
    const float enterX = x.enter > 0 ? x.enter : 0.f, enterXY = y.enter > enterX ? y.enter : enterX,
                enter = z.enter > enterXY ? z.enter : enterXY;
    wave.mayMeetSurface[i] = enter > leave ? 0u : 1u;
  }
}

BRUME_KERNEL void arriveInMedia(PathWave& wave) {
  for (std::size_t i = 0, n = wave.lanes(); i < n; ++i) {
    const float t = wave.t[i];
    const float dx = wave.d.x[i], dy = wave.d.y[i], dz = wave.d.z[i];
    wave.p.x[i] = wave.o.x[i] + dx * t;
    wave.p.y[i] = wave.o.y[i] + dy * t;
    wave.p.z[i] = wave.o.z[i] + dz * t;
    wave.wi[i] = packOctahedron<16>(-dx, -dy, -dz);
  }
}

BRUME_KERNEL void rouletteInMedia(float mostSurvive, PathWave& wave) {
  for (std::size_t i = 0, n = wave.lanes(); i < n; ++i) {
    const float t = wave.t[i];
    const float r = wave.power.r[i], g = wave.power.g[i], b = wave.power.b[i];
    const float nextR = r * wave.albedo.r[i], nextG = g * wave.albedo.g[i],
                nextB = b * wave.albedo.b[i];
    const float absR = std::abs(nextR), absG = std::abs(nextG), absB = std::abs(nextB);
    const float absGB = absG > absB ? absG : absB, largest = absR > absGB ? absR : absGB;
    const float ratio = largest / wave.usualPower[i];
    const float survival = ratio < mostSurvive ? ratio : mostSurvive;
    const float survives = wave.u1[i] < survival ? 1.f : 0.f, before = wave.isAlive[i];
    const float survivorR = nextR / survival, survivorG = nextG / survival,
                survivorB = nextB / survival;
    wave.power.r[i] = t < kInfinity ? survivorR : r;
    wave.power.g[i] = t < kInfinity ? survivorG : g;
    wave.power.b[i] = t < kInfinity ? survivorB : b;
    wave.isAlive[i] = t < kInfinity ? survives : before;
  }
}

BRUME_KERNEL void scatterInMedia(float meanCosine, std::uint32_t canStore, PathWave& wave) {
  const double g = meanCosine;
  for (std::size_t i = 0, n = wave.lanes(); i < n; ++i) {
    const bool collides = wave.t[i] < kInfinity;
    // The usual inverse, rearranged so that 1 - cos and 1 + cos are products of exact differences.
    const double u = wave.ux[i], inverse = 1 / (1 - g + 2 * g * u);
    const double back = (1 - g) * inverse, forth = (1 + g) * inverse;
    const auto oneMinusCos = static_cast<float>(2 * (back * back) * (1 - u) * (1 + g * u));
    const auto onePlusCos = static_cast<float>(2 * (forth * forth) * u * (1 - g * (1 - u)));
    const float sin2 = oneMinusCos * onePlusCos;
    const float sine = std::sqrt(sin2 > 0 ? sin2 : 0.f);
    const CosSin turn = cosSinOfTurn(wave.uy[i]);
    const float x = sine * turn.cosine, y = sine * turn.sine, z = 0.5f * (onePlusCos - oneMinusCos);

    // The frame of Frame::fromZ around the way that the path came.
    const float zx = wave.d.x[i], zy = wave.d.y[i], zz = wave.d.z[i];
    const float sign = std::copysign(1.f, zz);
    const float a = -1.f / (sign + zz);
    const float b = zx * zy * a;
    const float wx = (1 + sign * zx * zx * a) * x + b * y + zx * z;
    const float wy = sign * b * x + (sign + zy * zy * a) * y + zy * z;
    const float wz = -sign * zx * x - zy * y + zz * z;
    wave.d.x[i] = collides ? wx : zx;
    wave.d.y[i] = collides ? wy : zy;
    wave.d.z[i] = collides ? wz : zz;
    wave.o.x[i] = collides ? wave.p.x[i] : wave.o.x[i];
    wave.o.y[i] = collides ? wave.p.y[i] : wave.o.y[i];
    wave.o.z[i] = collides ? wave.p.z[i] : wave.o.z[i];
    wave.isInMedium[i] = collides ? 1u : wave.isInMedium[i];
    wave.canStore[i] = collides ? canStore : wave.canStore[i];
  }
}
