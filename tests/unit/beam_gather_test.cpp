// SPDX-License-Identifier: Apache-2.0
// The vectorised estimate against the sum as it is written, in double.
#include "transport/beam_gather.h"

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "core/sampling.h"
#include "support/beam_cases.h"
#include "transport/kernels.h"

namespace brume {
namespace {

using test::BeamScene;
using test::Rays;

std::vector<BeamPhoton> makePhotons(const std::vector<Beam>& beams, int count, float g) {
  const test::PhotonCloud cloud = test::awkwardPhotons(beams, count, 21);
  std::vector<BeamPhoton> photons;
  Rng rng(22);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    BeamPhoton photon;
    photon.p = cloud[i];
    photon.w = sampleUniformSphere(rng.uniform2());
    photon.power = Rgb(rng.uniform(), rng.uniform(), 1e-3f);
    photon.g = g;
    photons.push_back(photon);
  }
  return photons;
}

/// One term of the sum, from the feet as lookups find them.
BeamSum termOf(const Beam& beam, const BeamPhoton& photon, const BeamFoot<float>& foot,
               const Rgb& sigma_t) {
  const double r2 = sqr(double{beam.radius}), q = 1 - double{foot.d2} / r2;
  const double g = photon.g, cosine = -dot(Vec3d(photon.w), Vec3d(beam.d));
  const double phase = (1 - g * g) / (4 * M_PI * std::pow(1 + g * g - 2 * g * cosine, 1.5));
  const auto L = [&](float power, float sigma) {
    return 3 / (M_PI * r2) * q * q * phase * double{power} *
           std::exp(-double{sigma} * (double{foot.t} - double{beam.t0}));
  };
  return {L(photon.power.r, sigma_t.r), L(photon.power.g, sigma_t.g), L(photon.power.b, sigma_t.b),
          1};
}

void expectSums(const BeamScene& scene, const Rgb& sigma_t, float g) {
  SCOPED_TRACE(test::toString(scene.rays) + " g " + std::to_string(g));
  const std::vector<Beam> beams = test::makeBeams(scene, 20);
  const std::vector<BeamPhoton> photons = makePhotons(beams, 700, g);
  std::vector<BeamSum> expected(beams.size());
  LinearBeams(beams).accumulate(
      PhotonPositions(std::span(photons), &BeamPhoton::p), std::span(expected),
      [&](BeamSum& sum, std::uint32_t b, std::uint32_t i, const BeamFoot<float>& foot) {
        sum += termOf(beams[b], photons[i], foot, sigma_t);
      });
  std::uint64_t pairs = 0;
  for (const BeamQuadtree& tree :
       {BeamQuadtree(beams, scene.resolution), BeamQuadtree::inSpace(beams)}) {
    std::vector<BeamSum> sums(beams.size());
    gatherHomogeneous(tree, photons, sigma_t, sums);
    for (std::size_t b = 0; b < beams.size(); ++b) {
      ASSERT_EQ(sums[b].count, expected[b].count);
      if (sums[b].count == 0) {
        EXPECT_EQ(sums[b].r + sums[b].g + sums[b].b, 0);
        continue;
      }
      pairs += sums[b].count;
      // Kernels near their rim are differences of nearly equal numbers: the share of the peak
      // bounds their error. The transmittance may underflow to e^-87.
      const double peak = 3 / (M_PI * sqr(double{beams[b].radius})) * 1e-6 *
                          static_cast<double>(sums[b].count) * (1 - g * g) /
                          std::pow(1 - std::abs(g), 3) / (4 * M_PI);
      EXPECT_NEAR(sums[b].r, expected[b].r, 2e-6 * expected[b].r + peak) << b;
      EXPECT_NEAR(sums[b].g, expected[b].g, 2e-6 * expected[b].g + peak) << b;
      EXPECT_NEAR(sums[b].b, expected[b].b, 2e-6 * expected[b].b + 1e-3 * peak) << b;
    }
  }
  EXPECT_GT(pairs, 100u);
}

TEST(BeamGather, EqualsTheSum) {
  for (const Rays rays : test::kAllRays) {
    BeamScene scene;
    scene.rays = rays;
    scene.resolution = {31, 20};
    scene.radius = 0.1f;
    expectSums(scene, Rgb(0.3f, 0.5f, 0.9f), 0);
    expectSums(scene, Rgb(0.4f), 0.7f);
    expectSums(scene, Rgb(0.3f, 0.5f, 0.9f), -0.5f);
  }
}

TEST(BeamGather, NarrowBeams) {
  // Photons whose transmittance is a line over all beams that they are inside of: those of a
  // pinhole that are far enough; near ones are not.
  for (const Rays rays : {Rays::Pinhole, Rays::Environment})
    for (float radius : {0.003f, 0.01f, 0.03f}) {
      BeamScene scene;
      scene.rays = rays;
      scene.resolution = {31, 20};
      scene.radius = radius;
      expectSums(scene, Rgb(0.3f, 0.5f, 0.9f), 0);
      expectSums(scene, Rgb(0.4f), 0.7f);
      expectSums(scene, Rgb(0.3f, 0.5f, 0.9f), -0.5f);
      scene.isUneven = true;
      expectSums(scene, Rgb(0.6f), 0);
    }
}

TEST(BeamGather, BeamsThatStartFarApart) {
  BeamScene scene;
  scene.resolution = {31, 20};
  scene.isUneven = true;
  scene.radius = 0.2f;
  expectSums(scene, Rgb(5, 10, 0), 0);  // some tiles are wide
  expectSums(scene, Rgb(300, 20, 1), 0.3f);
}

TEST(BeamGather, WideBeamsInDenseMedia) {
  // The series of the transmittance does not reach from one beam to the next.
  BeamScene scene;
  scene.resolution = {12, 12};
  scene.radius = 2;
  expectSums(scene, Rgb(3, 2, 1), 0.2f);
  expectSums(scene, Rgb(40), 0);
}

TEST(BeamGather, NoAttenuation) { expectSums({}, Rgb(0), 0); }

TEST(BeamGather, SameBitsForAnyNumberOfThreads) {
  BeamScene scene;
  scene.rays = Rays::Mirrored;
  scene.radius = 0.1f;
  const std::vector<Beam> beams = test::makeBeams(scene, 30);
  const std::vector<BeamPhoton> photons = makePhotons(beams, 5000, 0.5f);
  for (const BeamQuadtree& tree :
       {BeamQuadtree(beams, scene.resolution), BeamQuadtree::inSpace(beams)}) {
    std::vector<BeamSum> first;
    for (const int threads : {1, 2, 7}) {
      setThreadCount(threads);
      std::vector<BeamSum> sums(beams.size());
      gatherHomogeneous(tree, photons, Rgb(0.3f), sums);
      if (threads == 1) first = sums;
      for (std::size_t b = 0; b < beams.size(); ++b) {
        EXPECT_EQ(sums[b].r, first[b].r);
        EXPECT_EQ(sums[b].count, first[b].count);
      }
    }
  }
  setThreadCount(0);
}

}  // namespace
}  // namespace brume
