// SPDX-License-Identifier: Apache-2.0
// The beam hierarchy against brute force: the same pairs with the same bits, in the same order.
#include "accelerators/beam_quadtree.h"

#include <gtest/gtest.h>

#include <cstring>

#include "accelerators/beam_raster.h"
#include "core/error.h"
#include "core/parallel.h"
#include "support/beam_cases.h"

namespace brume {
namespace {

using test::BeamScene;
using test::PhotonCloud;
using test::Rays;

struct Hit {
  std::uint32_t photon;
  float t, d2;
  friend bool operator<(const Hit& a, const Hit& b) { return a.photon < b.photon; }
  friend bool operator==(const Hit& a, const Hit& b) {
    return a.photon == b.photon && std::memcmp(&a.t, &b.t, sizeof a.t) == 0 &&
           std::memcmp(&a.d2, &b.d2, sizeof a.d2) == 0;
  }
};

/// Sum of a lookup: every photon of the beam.
struct Hits : std::vector<Hit> {
  Hits& operator+=(const Hits& o) {
    insert(end(), o.begin(), o.end());
    return *this;
  }
};

std::vector<Hits> hitsOf(const BeamLookup& lookup, const PhotonPositions& photons,
                         std::size_t beamCount) {
  std::vector<Hits> hits(beamCount);
  lookup.accumulate(photons, std::span(hits),
                    [](Hits& sum, std::uint32_t, std::uint32_t photon, const BeamFoot<float>& f) {
                      sum.push_back({photon, f.t, f.d2});
                    });
  return hits;
}

/// By the rule itself, without any lookup.
std::vector<Hits> bruteForce(const std::vector<Beam>& beams, const PhotonCloud& photons) {
  std::vector<Hits> hits(beams.size());
  for (std::size_t b = 0; b < beams.size(); ++b)
    for (std::size_t i = 0; i < photons.size(); ++i) {
      const auto foot = beamFoot(beams[b].o, beams[b].d, photons[i]);
      if (isInBeam(foot, {beams[b].t0, beams[b].t1}, sqr(beams[b].radius)))
        hits[b].push_back({static_cast<std::uint32_t>(i), foot.t, foot.d2});
    }
  return hits;
}

std::size_t countOf(const std::vector<Hits>& hits) {
  std::size_t n = 0;
  for (const Hits& h : hits) n += h.size();
  return n;
}

/// Expects that all lookups find what brute force finds; returns how many pairs that are.
std::size_t expectExact(const BeamScene& scene, int photonCount, std::uint64_t seed) {
  SCOPED_TRACE(test::toString(scene.rays));
  const std::vector<Beam> beams = test::makeBeams(scene, seed);
  const PhotonCloud photons = test::awkwardPhotons(beams, photonCount, seed + 1);
  const std::vector<Hits> expected = bruteForce(beams, photons);

  EXPECT_EQ(hitsOf(LinearBeams(beams), photons, beams.size()), expected);
  EXPECT_EQ(hitsOf(BeamQuadtree(beams, scene.resolution), photons, beams.size()), expected);
  if (RasterBeams::suits(beams))
    EXPECT_EQ(hitsOf(RasterBeams(beams), photons, beams.size()), expected);
  else
    EXPECT_NE(scene.rays, Rays::Pinhole);
  // Pieces of a beam come in another order.
  std::vector<Hits> inSpace = hitsOf(BeamQuadtree::inSpace(beams), photons, beams.size());
  for (Hits& hits : inSpace) std::sort(hits.begin(), hits.end());
  EXPECT_EQ(inSpace, expected);
  return countOf(expected);
}

TEST(BeamQuadtree, FindsWhatBruteForceFinds) {
  for (const Rays rays : test::kAllRays) {
    BeamScene scene;
    scene.rays = rays;
    scene.resolution = {61, 43};
    EXPECT_GT(expectExact(scene, 400, 1), 100u);
  }
}

TEST(BeamQuadtree, UnevenAndEmptyBeams) {
  for (const Rays rays : test::kAllRays) {
    BeamScene scene;
    scene.rays = rays;
    scene.resolution = {40, 50};
    scene.isUneven = true;
    scene.radius = 0.1f;
    EXPECT_GT(expectExact(scene, 500, 2), 100u);
  }
}

TEST(BeamQuadtree, CameraInsideTheMedium) {
  for (const Rays rays : test::kAllRays) {
    BeamScene scene;
    scene.rays = rays;
    scene.resolution = {32, 32};
    scene.t0 = 0;
    EXPECT_GT(expectExact(scene, 500, 3), 100u);
  }
}

TEST(BeamQuadtree, ImagesOfAllShapes) {
  for (const Vec2i& resolution : {Vec2i(1, 1), Vec2i(1, 700), Vec2i(700, 1), Vec2i(3, 2),
                                  Vec2i(8, 8), Vec2i(65, 17), Vec2i(2, 300)}) {
    SCOPED_TRACE(resolution.x);
    BeamScene scene;
    scene.resolution = resolution;
    scene.radius = 0.2f;
    EXPECT_GT(expectExact(scene, 500, 4), 50u);
  }
}

TEST(BeamQuadtree, LargeImagesWithFewBeams) {
  BeamScene scene;
  scene.resolution = {2048, 2048};
  // Trees whose tiles have two levels and three.
  for (const float share : {0.0005f, 0.003f}) {
    scene.share = share;
    EXPECT_GT(expectExact(scene, 120, 5), 50u);
  }
}

TEST(BeamQuadtree, ManyBeamsPerPixel) {
  for (const int n : {2, 5, 30}) {
    BeamScene scene;
    scene.resolution = {9, 11};
    scene.beamsPerPixel = n;
    EXPECT_GT(expectExact(scene, 600, 6), 100u);
  }
}

TEST(BeamQuadtree, RadiiFromNothingToEverything) {
  for (const float radius : {0.f, 1e-30f, 1e-6f, 10.f, 1e4f, 1e15f, 1e25f}) {
    SCOPED_TRACE(radius);
    for (const Rays rays : {Rays::Pinhole, Rays::Scattered}) {
      BeamScene scene;
      scene.rays = rays;
      scene.resolution = {16, 16};
      scene.radius = radius;
      expectExact(scene, 300, 7);
    }
  }
}

TEST(BeamQuadtree, ZeroLengthBeams) {
  for (const Rays rays : test::kAllRays) {
    BeamScene scene;
    scene.rays = rays;
    scene.resolution = {30, 30};
    scene.t0 = scene.t1 = 2;
    EXPECT_GT(expectExact(scene, 1000, 8), 0u);
  }
}

TEST(BeamQuadtree, LongAndThinBeamsFarFromTheOrigin) {
  for (const Rays rays : test::kAllRays) {
    BeamScene scene;
    scene.rays = rays;
    scene.resolution = {30, 30};
    scene.t1 = 1e5f;
    scene.radius = 1e-3f;
    expectExact(scene, 500, 9);
    scene.shift = Vec3(1e5f, -3e4f, 2e5f);
    scene.radius = 0.05f;
    expectExact(scene, 500, 10);
  }
}

TEST(BeamQuadtree, NoBeamsAndNoPhotons) {
  const std::vector<Beam> none;
  PhotonCloud photons;
  EXPECT_TRUE(hitsOf(BeamQuadtree(none, {4, 4}), photons, 0).empty());
  photons.add(Vec3(1));
  EXPECT_TRUE(hitsOf(BeamQuadtree(none, {4, 4}), photons, 0).empty());
  EXPECT_TRUE(hitsOf(BeamQuadtree::inSpace(none), photons, 0).empty());
  const std::vector<Beam> beams = test::makeBeams({}, 1);
  EXPECT_EQ(countOf(hitsOf(BeamQuadtree(beams, {64, 64}), PhotonCloud{}, beams.size())), 0u);
}

TEST(BeamQuadtree, RejectsBeamsThatAreNone) {
  const auto make = [](Beam beam) { return BeamQuadtree(std::span(&beam, 1), {4, 4}); };
  Beam beam{Vec3(0), 0, Vec3(0, 0, 1), 1, 1, 15};
  EXPECT_NO_THROW(make(beam));
  beam.pixel = 16;
  EXPECT_THROW(make(beam), InternalError);
  beam.pixel = 0;
  beam.t1 = kInfinity;
  EXPECT_THROW(make(beam), InternalError);
  beam.t1 = 1;
  beam.d = Vec3(0, 0, 1.1f);
  EXPECT_THROW(make(beam), InternalError);
  beam.d = Vec3(0, 0, 1);
  beam.radius = -1;
  EXPECT_THROW(make(beam), InternalError);
}

TEST(BeamQuadtree, SameSumsForAnyNumberOfThreads) {
  BeamScene scene;
  scene.rays = Rays::Mirrored;
  scene.radius = 0.1f;
  const std::vector<Beam> beams = test::makeBeams(scene, 11);
  const PhotonCloud photons = test::awkwardPhotons(beams, 5000, 12);
  const auto sums = [&](const BeamLookup& lookup) {
    std::vector<float> result(beams.size());
    lookup.accumulate(photons, std::span(result),
                      [](float& sum, std::uint32_t, std::uint32_t, const BeamFoot<float>& foot) {
                        sum += 1.f / (1.f + foot.d2);
                      });
    return result;
  };
  std::vector<float> first, firstInSpace;
  for (const int threads : {1, 2, 7}) {
    setThreadCount(threads);
    const auto image = sums(BeamQuadtree(beams, scene.resolution));
    const auto space = sums(BeamQuadtree::inSpace(beams));
    if (threads == 1) {
      first = image;
      firstInSpace = space;
    }
    EXPECT_EQ(image, first);
    EXPECT_EQ(space, firstInSpace);
  }
  setThreadCount(0);
}

}  // namespace
}  // namespace brume
