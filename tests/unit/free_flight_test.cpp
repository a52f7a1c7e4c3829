// SPDX-License-Identifier: Apache-2.0
#include "transport/free_flight.h"

#include <gtest/gtest.h>

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

TEST(FreeFlight, UniformMediaNeedNoLookup) {
  Rng rng(1);
  for (const Rgb& sigma_s : {Rgb(2), Rgb(2, 1, 0.5f), Rgb(0, 3, 0.1f), Rgb(0)}) {
    test::MediumSpec spec;
    spec.sigma_s = sigma_s;
    const auto volume = test::makeHomogeneous(spec);
    const Ray ray{Vec3(0.5f, 0.5f, -1), Vec3(0, 0, 1)};
    const Interval range = *volume->intersect(ray);
    const MediumAlongRay medium(*volume, ray, range);
    for (int i = 0; i < 500; ++i) {
      const Rgb channels = flightChannels(Rgb(rng.uniform(), rng.uniform(), rng.uniform()));
      const float uChannel = rng.uniform(), uDepth = rng.uniform();
      const FreeFlight a = sampleFreeFlight(medium, channels, uChannel, uDepth),
                       b = sampleFreeFlight(*volume->uniform(), range, channels, uChannel, uDepth);
      ASSERT_EQ(a.t.has_value(), b.t.has_value());
      EXPECT_NEAR(a.t.value_or(0), b.t.value_or(0), 1e-6f * a.t.value_or(0));
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(a.weight[c], b.weight[c], 1e-5f * a.weight[c]);
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
