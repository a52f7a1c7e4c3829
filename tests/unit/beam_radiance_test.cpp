// SPDX-License-Identifier: Apache-2.0
// Photons that no beam can receive are left out, and nothing else is.
#include "transport/beam_radiance.h"

#include <gtest/gtest.h>

#include "accelerators/beam_quadtree.h"
#include "core/sampling.h"
#include "support/beam_cases.h"
#include "support/volumes.h"

namespace brume {
namespace {

std::unique_ptr<Volume> haze() {
  test::MediumSpec spec;
  spec.sigma_s = Rgb(1, 2, 3);
  spec.p0 = Vec3(-40);
  spec.p1 = Vec3(40);
  return test::makeExponential(spec, 0.1f, 0.01f);
}

/// Around the beams, at their rims and ends, along all axes as far out as they reach, and far from
/// them.
std::vector<Photon> photonsFor(const std::vector<Beam>& beams) {
  test::PhotonCloud cloud = test::awkwardPhotons(beams, 3000, 3);
  for (const Beam& beam : beams)
    for (int axis = 0; axis < 6; ++axis) {
      Vec3 out(0);
      out[axis / 2] = axis % 2 ? 1.f : -1.f;
      out = out - dot(out, beam.d) * beam.d;
      if (lengthSquared(out) < 1e-6f || !(beam.t0 <= beam.t1)) continue;
      for (const float t : {beam.t0, beam.t1})
        cloud.add(beam.o + t * beam.d + 0.9999f * beam.radius * normalize(out));
    }
  std::vector<Photon> photons;
  Rng rng(4);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    photons.push_back(Photon::inMedium(cloud[i], sampleUniformSphere(rng.uniform2()),
                                       Rgb(rng.uniform()), PhotonClass::VolumeMultiple));
  return photons;
}

TEST(BeamRadiance, PhotonsOutOfReachAreNotMissed) {
  const std::unique_ptr<Volume> volume = haze();
  for (const test::Rays rays : test::kAllRays)
    for (const bool isUneven : {false, true}) {
      SCOPED_TRACE(test::toString(rays));
      test::BeamScene scene;
      scene.rays = rays;
      scene.resolution = {16, 16};
      scene.isUneven = isUneven;
      scene.radius = 0.1f;
      OwnedBeams beams;
      beams.beams = test::makeBeams(scene, 6);
      beams.owners.resize(beams.beams.size());
      const std::vector<Photon> photons = photonsFor(beams.beams);
      const VolumePhotons all(*volume, photons), near(*volume, photons, {reachOf(beams.beams)});
      EXPECT_EQ(all.outsideCount(), 0u);
      EXPECT_GT(near.outsideCount(), 10u);
      const LinearBeams lookup(beams.beams);
      const auto expected = gatherBeams(*volume, beams, lookup, all),
                 found = gatherBeams(*volume, beams, lookup, near);
      std::uint64_t pairs = 0;
      for (std::size_t b = 0; b < expected.size(); ++b) {
        EXPECT_EQ(found[b].count, expected[b].count);
        EXPECT_EQ(found[b].r, expected[b].r);
        EXPECT_EQ(found[b].g, expected[b].g);
        EXPECT_EQ(found[b].b, expected[b].b);
        pairs += found[b].count;
      }
      EXPECT_GT(pairs, 100u);
    }
}

TEST(BeamRadiance, WithoutBeamsNoPhotonIsKept) {
  const std::unique_ptr<Volume> volume = haze();
  const std::vector<Photon> photons = photonsFor(test::makeBeams({}, 1));
  Beam empty;
  empty.t0 = 1;
  const VolumePhotons kept(*volume, photons, {reachOf(std::array{empty})});
  EXPECT_TRUE(kept.all().empty());
  EXPECT_EQ(kept.outsideCount(), photons.size());
}

}  // namespace
}  // namespace brume
