// SPDX-License-Identifier: Apache-2.0
// The estimates of a photon map against the sums they stand for, and their bias against theory.
#include "transport/photon_estimates.h"

#include <gtest/gtest.h>

#include "support/volumes.h"
#include "transport/kernels.h"

namespace brume {
namespace {

using Power = VolumePhotonMap::Power;

std::vector<Photon> randomPhotons(int n, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Photon> photons;
  for (int i = 0; i < n; ++i) {
    const Vec3 p(rng.uniform(), rng.uniform(), rng.uniform());
    photons.push_back(Photon::inMedium(p, test::randomDirection(rng),
                                       Rgb(rng.uniform(), rng.uniform(), rng.uniform()) * 1e-3f,
                                       PhotonClass::VolumeMultiple));
  }
  return photons;
}

std::vector<std::unique_ptr<Volume>> media() {
  test::MediumSpec spec;
  spec.sigma_a = Rgb(0.3f, 0.5f, 0.8f);
  spec.sigma_s = Rgb(2, 1.5f, 0.4f);
  std::vector<std::unique_ptr<Volume>> result;
  result.push_back(test::makeHomogeneous(spec));
  for (const float g : {0.8f, -0.6f}) {
    spec.g = g;
    result.push_back(test::makeHomogeneous(spec));
  }
  spec.g = 0.7f;
  result.push_back(test::makeExponential(spec, 1, 3));
  spec.sigma_a = Rgb(0.2f);
  Rng rng(3);
  result.push_back(test::makeGrid(spec, 4, 5, 6, test::randomDensities(4 * 5 * 6, rng)));
  return result;
}

/// Rays through the unit cube, with ends inside of it too.
std::vector<Ray> someRays() {
  Rng rng(4);
  std::vector<Ray> rays;
  for (int i = 0; i < 20; ++i) {
    const Vec3 through(rng.uniform(), rng.uniform(), rng.uniform());
    const Vec3 d = test::randomDirection(rng);
    rays.push_back({through - d * (2 * rng.uniform()), d});
    rays.back().tMax = i % 2 == 0 ? kInfinity : 1 + rng.uniform();
  }
  return rays;
}

// Sums of some hundred floats, each with a few roundings, and directions packed into 32 bits (the
// expected sums unpack them as well).
constexpr double kRounding = 2e-5;

void expectNear(const Rgb& L, const Vec3d& expected) {
  for (int c = 0; c < 3; ++c) {
    const double e = expected[c];
    EXPECT_NEAR(double{L[c]}, e, kRounding * e);
  }
}

TEST(VolumePhotonMap, BeamRadianceIsItsSum) {
  for (const auto& volume : media()) {
    const std::vector<Photon> photons = randomPhotons(3000, 1);
    const VolumePhotonMap map(*volume, photons, Power::Scattered);
    const std::vector<float> radii2 = adaptiveRadii2(map.tree(), 20);
    for (const PhotonBvh& bvh : {PhotonBvh(map.tree(), 0.2f), PhotonBvh(map.tree(), radii2)})
      for (const Ray& ray : someRays()) {
        const auto range = volume->intersect(ray);
        if (!range) continue;
        const MediumAlongRay medium(*volume, ray, *range);
        Vec3d expected(0);
        std::uint64_t count = 0;
        // By the photons as they were traced; radii by where the map keeps them.
        for (std::size_t i = 0; i < map.size(); ++i) {
          const Vec3 p = map.tree().point(i);
          const auto photon = std::find_if(photons.begin(), photons.end(),
                                           [&](const Photon& x) { return x.p == p; });
          ASSERT_NE(photon, photons.end());
          const Vec3d q = Vec3d(p) - Vec3d(ray.o), d = normalize(Vec3d(ray.d));
          const double t = dot(q, d), d2 = dot(q - t * d, q - t * d);
          const double r2 = double{bvh.radius2(i)};
          if (t < double{range->t0} || t > double{range->t1} || d2 >= r2) continue;
          const double kernel = 3 / (M_PI * r2) * sqr(1 - d2 / r2);
          const auto tf = static_cast<float>(t);
          const Rgb tau = volume->opticalDepth(ray, {range->t0, tf});
          const MediumCoefficients c = volume->at(p);
          const Rgb phase = volume->phase(p, -ray.d, photon->wi.unpack());
          for (int k = 0; k < 3; ++k)
            expected[k] += std::exp(-double{tau[k]}) * double{c.sigma_s[k] / c.sigma_t()[k]} *
                           double{phase[k] * photon->power[k]} * kernel;
          ++count;
        }
        const BeamEstimate estimate = beamRadiance(map, bvh, medium);
        EXPECT_EQ(estimate.photons, count);
        expectNear(estimate.L, expected);
      }
  }
}

TEST(VolumePhotonMap, PointRadianceIsItsSum) {
  for (const auto& volume : media()) {
    const std::vector<Photon> photons = randomPhotons(3000, 2);
    const VolumePhotonMap map(*volume, photons, Power::Arriving);
    Rng rng(5);
    BallSearch search;
    for (int q = 0; q < 20; ++q) {
      const Vec3 p(rng.uniform(), rng.uniform(), rng.uniform()), wo = test::randomDirection(rng);
      std::vector<std::pair<double, const Photon*>> byDistance;
      for (const Photon& photon : photons)
        byDistance.emplace_back(dot(Vec3d(photon.p - p), Vec3d(photon.p - p)), &photon);
      std::sort(byDistance.begin(), byDistance.end());
      const auto sum = [&](std::size_t count, double r2) {
        Vec3d expected(0);
        for (std::size_t i = 0; i < count; ++i) {
          const double kernel =
              105 / (32 * M_PI * std::pow(r2, 1.5)) * sqr(1 - byDistance[i].first / r2);
          const Photon& photon = *byDistance[i].second;
          const Rgb value = volume->phase(p, wo, photon.wi.unpack()) * photon.power;
          for (int k = 0; k < 3; ++k) expected[k] += double{value[k]} * kernel;
        }
        return expected;
      };
      const auto within = [&](double r) {
        return static_cast<std::size_t>(std::count_if(
            byDistance.begin(), byDistance.end(), [&](const auto& x) { return x.first < r * r; }));
      };
      // All within a radius.
      const BeamEstimate fixed = pointRadiance(map, {0, 0.2f}, p, wo, search);
      EXPECT_EQ(fixed.photons, within(0.2));
      expectNear(fixed.L, sum(within(0.2), 0.2 * 0.2));
      // The 30 nearest: 29 count, and the 30th sets the radius.
      const BeamEstimate nearest = pointRadiance(map, {30}, p, wo, search);
      EXPECT_EQ(nearest.photons, 29u);
      expectNear(nearest.L, sum(29, byDistance[29].first));
      // However far the last lookup reached.
      for (const std::size_t other : {2u, 10u, 29u, 31u, 40u, 300u, 3000u}) {
        search.radius2OfNearest(map.tree(), p, other);
        const BeamEstimate again = pointRadiance(map, {30}, p, wo, search);
        EXPECT_EQ(again.photons, 29u);
        EXPECT_EQ(again.L, nearest.L) << "the same bits after a search of " << other;
      }
      // Fewer than asked for within the radius: that radius.
      const BeamEstimate few = pointRadiance(map, {2000, 0.2f}, p, wo, search);
      EXPECT_EQ(few.photons, within(0.2));
      expectNear(few.L, sum(within(0.2), 0.2 * 0.2));
    }
  }
}

TEST(VolumePhotonMap, LeavesOutWhatDoesNotScatter) {
  test::MediumSpec spec;
  spec.sigma_a = Rgb(1);
  const auto volume = test::makeHomogeneous(spec);
  const std::vector<Photon> photons = randomPhotons(100, 3);
  EXPECT_EQ(VolumePhotonMap(*volume, photons, Power::Scattered).size(), 0u);
  EXPECT_EQ(VolumePhotonMap(*volume, photons, Power::Arriving).size(), 100u);
}

TEST(VolumePhotonMap, NeedsAtMost32BytesPerPhotonWithItsRadii) {
  test::MediumSpec spec;
  spec.sigma_s = Rgb(1);
  const auto volume = test::makeHomogeneous(spec);
  const VolumePhotonMap map(*volume, randomPhotons(1 << 15, 4), Power::Scattered);
  const PhotonBvh bvh(map.tree(), adaptiveRadii2(map.tree(), 50));
  EXPECT_LE(map.memoryBytes() + bvh.memoryBytes(), 32 * map.size());
}

/// Photons at evenly spread places with the density 1 + cos(k (x - 1/2)) / 2 in their powers, light
/// of the phase function 1/(4 pi), in a medium so thin that it does not attenuate: an exact
/// density.
class BiasOfEstimates : public ::testing::Test {
 protected:
  static constexpr int kSide = 100;
  static constexpr float kWave = 3 * kPi;

  BiasOfEstimates() {
    test::MediumSpec spec;
    spec.sigma_s = Rgb(1e-6f);
    volume_ = test::makeHomogeneous(spec);
    Rng rng(1);
    for (int i = 0; i < kSide * kSide * kSide; ++i) {
      // Jittered in each cell.
      const Vec3 cell(static_cast<float>(i % kSide), static_cast<float>(i / kSide % kSide),
                      static_cast<float>(i / kSide / kSide));
      const Vec3 p = (cell + Vec3{rng.uniform(), rng.uniform(), rng.uniform()}) / float{kSide};
      const float density = 1 + 0.5f * std::cos(kWave * (p.x - 0.5f));
      photons_.push_back(Photon::inMedium(p, Vec3(0, 0, 1), Rgb(density / (kSide * kSide * kSide)),
                                          PhotonClass::VolumeMultiple));
    }
  }
  /// The exact value in the middle, and its Laplacian.
  static constexpr double kExact = 1.5, kLaplacian = -0.5 * double{kWave} * double{kWave};

  std::unique_ptr<Volume> volume_;
  std::vector<Photon> photons_;
};

TEST_F(BiasOfEstimates, OfBeamsFallsWithTheSquareOfTheRadius) {
  const VolumePhotonMap map(*volume_, photons_, Power::Scattered);
  const Ray ray{Vec3(0.5f, 0.5f, -1), Vec3(0, 0, 1)};
  const MediumAlongRay medium(*volume_, ray, *volume_->intersect(ray));
  const auto error = [&](float r) {
    const double L = double{beamRadiance(map, PhotonBvh(map.tree(), r), medium).L.g};
    return L * 4 * M_PI / kExact - 1;
  };
  const double coarse = error(0.2f), fine = error(0.1f);
  // Theory up to the next order, (k r)^4, which is 8 % of the bias at the coarse radius; jittered
  // photons scatter the estimates by 0.1 %.
  const double expected = double{kDiscKernelBias} * 0.04 * kLaplacian / kExact;
  EXPECT_NEAR(coarse, expected, 0.15 * std::abs(expected));
  EXPECT_NEAR(fine / coarse, 0.25, 0.04);
  EXPECT_NEAR((4 * fine - coarse) / 3, 0, 0.005) << "extrapolated to radius 0";
}

TEST_F(BiasOfEstimates, OfPointsFallsWithTheSquareOfTheRadius) {
  const VolumePhotonMap map(*volume_, photons_, Power::Arriving);
  BallSearch search;
  const auto error = [&](float r) {
    // The mean over a plane in which the density is the same.
    double L = 0;
    for (int i = 0; i < 24 * 24; ++i) {
      const Vec3 p(0.5f, 0.25f + static_cast<float>(i % 24) / 48,
                   0.25f + static_cast<float>(i / 24) / 48);
      L += double{pointRadiance(map, {0, r}, p, Vec3(0, 0, 1), search).L.g} / (24 * 24);
    }
    return L * 4 * M_PI / kExact - 1;
  };
  const double coarse = error(0.2f), fine = error(0.1f);
  const double expected = double{kBallKernelBias} * 0.04 * kLaplacian / kExact;
  EXPECT_NEAR(coarse, expected, 0.15 * std::abs(expected));
  EXPECT_NEAR(fine / coarse, 0.25, 0.04);
  EXPECT_NEAR((4 * fine - coarse) / 3, 0, 0.005) << "extrapolated to radius 0";
}

TEST_F(BiasOfEstimates, NearestPhotonsCountTheDensityRight) {
  // Random places and equal powers: the mean over many places is the density, without the k/(k-1)
  // that counting the farthest photon would add (10 % here).
  constexpr int kN = 50'000, kQueries = 3000;
  std::vector<Photon> photons = randomPhotons(kN, 7);
  for (Photon& photon : photons) photon.power = Rgb(1.f / kN);
  const VolumePhotonMap map(*volume_, photons, Power::Arriving);
  Rng rng(8);
  BallSearch search;
  double sum = 0;
  for (int i = 0; i < kQueries; ++i) {
    const Vec3 p = Vec3(0.2f) + 0.6f * Vec3(rng.uniform(), rng.uniform(), rng.uniform());
    sum += double{pointRadiance(map, {11}, p, Vec3(0, 0, 1), search).L.g} * 4 * M_PI;
  }
  // 3000 estimates of 10 photons each, on 50,000 photons: 1 %.
  EXPECT_NEAR(sum / kQueries, 1, 0.03);
}

}  // namespace
}  // namespace brume
