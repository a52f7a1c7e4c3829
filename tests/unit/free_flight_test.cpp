// SPDX-License-Identifier: Apache-2.0
#include "transport/free_flight.h"

#include <gtest/gtest.h>

#include "core/sampling.h"
#include "support/volumes.h"

namespace brume {
namespace {

/// Share of all numbers that end the flight through 1 unit of medium; the depth is cut into the
/// 2^24 numbers that a float draws, of which the first kDepths may be shallow enough.
double shareOfCollisions(const Volume& volume, const Rgb& channels) {
  constexpr int kDepths = 64, kChannels = 3000;
  const Ray ray{Vec3(0.5f, 0.5f, -1), Vec3(0, 0, 1)};
  const MediumAlongRay medium(volume, ray, *volume.intersect(ray));
  int collisions = 0;
  for (int i = 0; i < kDepths; ++i)
    for (int j = 0; j < kChannels; ++j) {
      const float uChannel = (static_cast<float>(j) + 0.5f) / kChannels,
                  uDepth = static_cast<float>(i) * 0x1p-24f;
      if (sampleFreeFlight(medium, channels, uChannel, uDepth).t) ++collisions;
    }
  return collisions * 0x1p-24 / kChannels;
}

TEST(FreeFlight, ThinMediaCollideByTheirDepth) {
  // By 24 bits alone the first would be 0 or 6e-8 (100 %), the last one 1 % off.
  for (const double depth : {2e-8, 1e-7, 1e-6, 2.5e-6}) {
    test::MediumSpec spec;
    spec.sigma_s = Rgb(static_cast<float>(depth));
    const auto volume = test::makeHomogeneous(spec);
    for (const Rgb& channels : {Rgb(1.f / 3), Rgb(0.7f, 0.2f, 0.1f), Rgb(1, 0, 0)})
      EXPECT_NEAR(shareOfCollisions(*volume, channels) / depth, 1, 2e-3) << depth;
  }
}

/// Flights through all that the ray meets, by what knows the medium least.
FreeFlight byLookup(const Volume& volume, const Ray& ray, const Rgb& power, Vec2 u) {
  const auto range = volume.intersect(ray);
  if (!range) return {};
  return sampleFreeFlight(MediumAlongRay(volume, ray, *range), flightChannels(power), u.x, u.y);
}

void expectAlike(const FreeFlight& a, const FreeFlight& b) {
  ASSERT_EQ(a.t.has_value(), b.t.has_value());
  EXPECT_NEAR(a.t.value_or(0), b.t.value_or(0), 1e-5f * a.t.value_or(0));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a.weight[c], b.weight[c], 1e-4f * a.weight[c]);
}

/// A wave of one path.
PathWave waveOf(const Ray& ray, bool isInMedium, const Rgb& power, Vec2 u) {
  PathWave wave{};
  wave.count = 1;
  wave.o.set(0, ray.o);
  wave.d.set(0, ray.d);
  wave.power.set(0, power);
  wave.isInMedium[0] = isInMedium ? 1 : 0;
  wave.uChannel[0] = u.x, wave.uDepth[0] = u.y;
  return wave;
}

TEST(FreeFlight, UniformMediaNeedNoLookup) {
  // Grey media draw from other bits of the numbers: the same channel must draw in both.
  Rng rng(1);
  for (const Rgb& sigma_s : {Rgb(2), Rgb(2, 1, 0.5f), Rgb(0, 3, 0.1f), Rgb(0)}) {
    test::MediumSpec spec;
    spec.sigma_s = sigma_s;
    const auto volume = test::makeHomogeneous(spec);
    const auto flights = UniformFlights::through(*volume);
    ASSERT_TRUE(flights);
    const Vec3 centre = volume->bounds().center();
    int inside = 0;
    for (int i = 0; i < 2000; ++i) {
      const Ray ray{centre + 2.f * sampleUniformSphere(rng.uniform2()) * rng.uniform(),
                    sampleUniformSphere(rng.uniform2())};
      const bool isInside = volume->bounds().contains(ray.o);
      inside += isInside ? 1 : 0;
      const Rgb power =
          sigma_s == Rgb(2) ? Rgb(1, 0, 0) : Rgb(rng.uniform(), rng.uniform(), rng.uniform());
      const Vec2 u = rng.uniform2();
      const FreeFlight a = byLookup(*volume, ray, power, u);
      for (const bool isInMedium : {false, true}) {
        if (isInMedium && !isInside) continue;
        PathWave wave = waveOf(ray, isInMedium, power, u);
        flights->sample(wave);
        FreeFlight b;
        if (wave.collides(0)) {
          flights->weighCollisions(wave);
          b = {wave.t[0], wave.power[0] / power};
          for (int c = 0; c < 3; ++c)
            if (power[c] == 0) b.weight[c] = a.weight[c];
        } else {
          b = {std::nullopt, flights->weightAt(kInfinity, wave, 0)};
        }
        expectAlike(a, b);
      }
    }
    EXPECT_GT(inside, 100);
  }
}

TEST(FreeFlight, EndOfAUniformFlightByASurfaceCountsTheWayToIt) {
  test::MediumSpec spec;
  spec.sigma_s = Rgb(2, 1, 0.5f);
  const auto volume = test::makeHomogeneous(spec);
  const auto flights = UniformFlights::through(*volume);
  Ray ray{Vec3(0.5f, 0.5f, -1), Vec3(0, 0, 1)};
  const Rgb power(0.2f, 0.5f, 0.3f);
  const Vec2 far(0.3f, kOneMinusEpsilon);
  PathWave wave = waveOf(ray, false, power, far);
  flights->sample(wave);
  ASSERT_FALSE(wave.collides(0));
  for (const float t : {0.5f, 1.25f, 1.75f, 3.f}) {
    ray.tMax = t;
    const auto range = volume->intersect(ray);
    const Rgb Tr = range ? volume->transmittance(ray, *range) : Rgb(1);
    const float mean = dot(Vec3(power.r, power.g, power.b), Vec3(Tr.r, Tr.g, Tr.b));
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(flights->weightAt(t, wave, 0)[c], Tr[c] / mean, 1e-5f) << t;
  }
}

TEST(FreeFlight, ProportionalMediaNeedOneWalk) {
  Rng rng(1);
  for (const bool isGrid : {true, false})
    for (const Rgb& sigma_s : {Rgb(2), Rgb(2, 1, 0.5f), Rgb(0, 3, 0.1f)}) {
      test::MediumSpec spec;
      spec.sigma_s = sigma_s;
      const auto volume =
          isGrid ? test::makeGrid(spec, 3, 2, 2, {1, 2, 0, .5f, 3, 1, 0, 0, .1f, 2, 1, 4})
                 : test::makeExponential(spec, 1.f, 2.f);
      ASSERT_NE(volume->proportions(), nullptr);
      const Vec3 centre = volume->bounds().center();
      for (int i = 0; i < 1000; ++i) {
        const Ray ray{centre + 2.f * sampleUniformSphere(rng.uniform2()) * rng.uniform(),
                      sampleUniformSphere(rng.uniform2())};
        const auto range = volume->intersect(ray);
        if (!range) continue;
        const Rgb power =
            sigma_s == Rgb(2) ? Rgb(1, 0, 0) : Rgb(rng.uniform(), rng.uniform(), rng.uniform());
        const Vec2 u = rng.uniform2();
        expectAlike(byLookup(*volume, ray, power, u),
                    sampleFreeFlight(*volume, ray, *range, flightChannels(power), u.x, u.y));
      }
    }
}

TEST(FreeFlight, WeightsAreThoseOfTheMeanDensity) {
  test::MediumSpec spec;
  spec.sigma_s = Rgb(2, 1, 0.5f);
  const auto volume = test::makeHomogeneous(spec);
  const Ray ray{Vec3(0.5f, 0.5f, -1), Vec3(0, 0, 1)};
  const MediumAlongRay medium(*volume, ray, *volume->intersect(ray));
  const Rgb channels(0.2f, 0.5f, 0.3f);
  for (const float uChannel : {0.1f, 0.4f, 0.9f})
    for (const float uDepth : {0.05f, 0.3f, 0.95f}) {
      const FreeFlight flight = sampleFreeFlight(medium, channels, uChannel, uDepth);
      // Expected weight, of channel and distance: 1 in all channels.
      const Rgb mean = channels * flight.weight;
      const float t = flight.t ? *flight.t - 1 : 1;
      for (int c = 0; c < 3; ++c) {
        const double sigma = double{spec.sigma_s[c]};
        const double density = (flight.t ? sigma : 1) * std::exp(-sigma * double{t});
        double pdf = 0;
        for (int k = 0; k < 3; ++k) {
          const double other = double{spec.sigma_s[k]};
          pdf += double{channels[k]} * (flight.t ? other : 1) * std::exp(-other * double{t});
        }
        EXPECT_NEAR(double{flight.weight[c]}, density / pdf, 1e-5 * density / pdf);
      }
      EXPECT_LT(mean.maxChannel(), 1 + 1e-5f) << "no weight exceeds 1 / (share of its channel)";
    }
}

}  // namespace
}  // namespace brume
