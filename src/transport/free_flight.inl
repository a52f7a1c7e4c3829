// SPDX-License-Identifier: Apache-2.0
// Flights of many paths through a uniform medium, included once for each kind of Lanes (lanes.h).

#include "accelerators/lanes_exp.inl"

/// -ln x for x in [2^-1022, 1], in error by less than 1e-11 of itself.
[[gnu::always_inline]] inline BRUME_KERNEL double minusLog(double x) {
  // x = 2^k z, z in [sqrt(1/2), sqrt(2)); ln z = 2 artanh((z - 1) / (z + 1)).
  constexpr std::uint64_t kSqrtHalf = std::bit_cast<std::uint64_t>(0x1.6a09e667f3bcdp-1);
  constexpr double kIntegers = 0x1p52;  // whose lowest bits are an integer
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const std::uint64_t biased = (bits - kSqrtHalf + (std::uint64_t{1024} << 52)) >> 52;
  const double k =
      std::bit_cast<double>(biased | std::bit_cast<std::uint64_t>(kIntegers)) - (kIntegers + 1024);
  const auto z = std::bit_cast<double>(bits - (biased << 52) + (std::uint64_t{1024} << 52));
  const double s = (z - 1) / (z + 1), s2 = s * s;
  double series = 1. / 13;
  series = series * s2 + 1. / 11;
  series = series * s2 + 1. / 9;
  series = series * s2 + 1. / 7;
  series = series * s2 + 1. / 5;
  series = series * s2 + 1. / 3;
  series = series * s2 + 1;
  return -(k * 0x1.62e42fefa39efp-1 + 2 * s * series);
}

/// A ray in double, and the stretch of it inside some pairs of a box's faces, which may be empty.
struct Stretch {
  double ox, oy, oz, dx, dy, dz;
  double t0 = 0, t1 = HUGE_VAL;
};
[[gnu::always_inline]] inline BRUME_KERNEL void clip(const UniformFlights::Box& box, std::size_t a,
                                                     Stretch& ray) {
  const Vec3d& axis = box.axes[a];
  const double place = axis.x * ray.ox + axis.y * ray.oy + axis.z * ray.oz;
  const double inverse = 1 / (axis.x * ray.dx + axis.y * ray.dy + axis.z * ray.dz);
  const double toLo = (box.lo[a] - place) * inverse, toHi = (box.hi[a] - place) * inverse;
  // Rays in the plane of a face are inside: 0 times infinity fails both comparisons.
  const double enter = inverse > 0 ? toLo : toHi, leave = inverse > 0 ? toHi : toLo;
  ray.t0 = enter > ray.t0 ? enter : ray.t0;
  ray.t1 = leave < ray.t1 ? leave : ray.t1;
}

/// The medium that the rays cross and, where all channels are alike, the depth of collisions.
template <bool kIsGrey>
[[gnu::always_inline]] inline BRUME_KERNEL void flyOf(const UniformFlights::Box& box,
                                                      PathWave& wave) {
  const double perRed = box.perSigma.x, perGreen = box.perSigma.y, perBlue = box.perSigma.z;
  for (std::size_t i = 0, n = wave.lanes(); i < n; ++i) {
    Stretch ray{wave.o.x[i], wave.o.y[i], wave.o.z[i], wave.d.x[i], wave.d.y[i], wave.d.z[i]};
    clip(box, 0, ray);
    clip(box, 1, ray);
    clip(box, 2, ray);
    // Paths that start in the medium do so although rounding may have moved them out of it.
    const float entry = static_cast<float>(ray.t0), exit = static_cast<float>(ray.t1);
    const float from = wave.isInMedium[i] != 0 ? 0.f : entry, to = ray.t0 < ray.t1 ? exit : -1.f;

    // The channel that draws. What chose it refines the depth as well: 24 bits alone would draw
    // depths below 1e-6 by the wrong probability.
    double rest = wave.uChannel[i], perSigma = perRed;
    if constexpr (!kIsGrey) {
      const float r = std::abs(wave.power.r[i]), g = std::abs(wave.power.g[i]),
                  b = std::abs(wave.power.b[i]);
      const float sum = r + g + b, cr = r / sum, cg = g / sum, cb = b / sum;
      const float u = wave.uChannel[i];
      const float toBlue = cb > 0 ? cr + cg : kInfinity;
      const float share = u < cr ? cr : u < toBlue ? cg : cb;
      const double beforeBlue = static_cast<double>(cr) + static_cast<double>(cg);
      const double before = u < cr ? 0. : u < toBlue ? cr : beforeBlue;
      const double part = (u - before) / share, above = part > 0 ? part : 0.;
      rest = above < kOneMinusEpsilon ? above : kOneMinusEpsilon;
      perSigma = u < cr ? perRed : u < toBlue ? perGreen : perBlue;
      wave.channels.r[i] = cr;
      wave.channels.g[i] = cg;
      wave.channels.b[i] = cb;
    }
    // The argument of the logarithm is exact to 2^-53, and the depth is no less than 2^-48.
    const double depth = minusLog(1 - (wave.uDepth[i] + rest * 0x1p-24));
    const double t = from + depth * perSigma;
    const float collision = static_cast<float>(t);
    wave.t[i] = t <= to ? collision : kInfinity;
    wave.mediaFrom[i] = from;
    wave.mediaTo[i] = to;
  }
}
BRUME_KERNEL void fly(const UniformFlights::Box& box, PathWave& wave) {
  box.isGrey ? flyOf<true>(box, wave) : flyOf<false>(box, wave);
}

/// sigma_t Tr over its mean by the channels' probabilities.
BRUME_KERNEL void weighCollisions(const UniformFlights::Box& box, PathWave& wave) {
  const Lanes infinity = Lanes::all(kInfinity), zero = Lanes::all(0.f);
  for (std::size_t i = 0, n = wave.lanes(); i < n; i += kLanes) {
    const Lanes t = Lanes::load(&wave.t[i]);
    const Lanes collides = lessMask(t, infinity);
    if (bitsOf(collides) == 0) continue;
    const Lanes way = t - Lanes::load(&wave.mediaFrom[i]);
    const std::array<PathWave::Floats*, 3> channels{&wave.channels.r, &wave.channels.g,
                                                    &wave.channels.b},
        powers{&wave.power.r, &wave.power.g, &wave.power.b};
    std::array<Lanes, 3> density;
    Lanes pdf = zero;
    for (std::size_t c = 0; c < 3; ++c) {
      const float excess = box.excess[static_cast<int>(c)];
      const Lanes Tr = excess > 0 ? expOf(zero - Lanes::all(excess) * way) : Lanes::all(1.f);
      density[c] = Lanes::all(box.sigma_t[static_cast<int>(c)]) * Tr;
      pdf = pdf + Lanes::load(&(*channels[c])[i]) * density[c];
    }
    for (std::size_t c = 0; c < 3; ++c) {
      float* const power = &(*powers[c])[i];
      const Lanes before = Lanes::load(power);
      select(collides, before * (density[c] / pdf), before).store(power);
    }
  }
}
