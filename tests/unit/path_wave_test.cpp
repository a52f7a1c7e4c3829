// SPDX-License-Identifier: Apache-2.0
#include "transport/path_wave.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>

#include "core/lanes_math.h"
#include "core/phase.h"
#include "core/sampling.h"
#include "core/turns.h"
#include "transport/free_flight.h"
#include "transport/octahedron.h"
#include "transport/photon.h"

namespace brume {
namespace {

/// Paths of all kinds in and around the box [-1, 1]^3; some fly along an axis, some in a face.
PathWave someWave(std::size_t count) {
  PathWave wave{};
  wave.count = count;
  for (std::size_t i = 0; i < count; ++i) {
    Rng rng(i);
    wave.isInMedium[i] = i % 2 == 0 ? 1 : 0;
    wave.o.set(i, 2.f * sampleUniformSphere(rng.uniform2()) * rng.uniform());
    wave.d.set(i, i % 16 == 3 ? Vec3(0, 0, -1) : sampleUniformSphere(rng.uniform2()));
    if (i % 32 == 3) wave.o.set(i, Vec3(1, 0.5f, 3));
    wave.power.set(i, {rng.uniform(), rng.uniform(), i % 5 == 0 ? 0 : rng.uniform()});
    wave.usualPower[i] = 0.5f;
    wave.albedo.set(i, {0.9f, 0.8f, rng.uniform()});
    wave.canStore[i] = kVolumePhotons.bits();
    wave.wanted[i] = i % 7 == 0 ? 1 : 0x3f;
    wave.path[i] = static_cast<std::uint32_t>(i);
    const std::uint64_t key = rng.bits64();
    wave.keyLow[i] = static_cast<std::uint32_t>(key);
    wave.keyHigh[i] = static_cast<std::uint32_t>(key >> 32);
    wave.isAlive[i] = i % 3 == 0 ? 0.f : 1.f;
  }
  return wave;
}

UniformFlights::Box someBox(bool isGrey) {
  UniformFlights::Box box;
  box.sigma_t = isGrey ? Rgb(1) : Rgb(1, 2, 0.5f);
  box.excess = box.sigma_t - Rgb(box.sigma_t.minChannel());
  box.isGrey = isGrey;
  for (int c = 0; c < 3; ++c) box.perSigma[c] = 1 / double{box.sigma_t[c]};
  box.axes = {Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)};
  box.lo = {-1, -1, -1};
  box.hi = {1, 1, 1};
  return box;
}

#define BRUME_KERNELS "unit/path_wave_steps.inl"
#include "core/both_lanes.inl"

template <class T>
void expectSameBits(const T& a, const T& b, std::size_t count, const char* what) {
  EXPECT_EQ(std::memcmp(a.data(), b.data(), count * sizeof(a[0])), 0) << what;
}

TEST(PathWave, BothKindsOfLanesGiveTheSameBits) {
  if (!hasAvx2()) GTEST_SKIP() << "no AVX2";
  for (const bool isGrey : {true, false})
    for (const std::size_t count :
         {std::size_t{0}, std::size_t{1}, std::size_t{13}, PathWave::kSize}) {
      PathWave a = someWave(count), b = a;
      generic::advance(someBox(isGrey), a);
      avx2::advance(someBox(isGrey), b);
      ASSERT_EQ(a.count, b.count);
      std::size_t collisions = 0;
      for (std::size_t i = 0; i < a.count; ++i) collisions += a.collides(i) ? 1 : 0;
      if (count == PathWave::kSize) {
        EXPECT_GT(collisions, 20u);
        EXPECT_LT(collisions, a.count - 20);
      }
      expectSameBits(a.path, b.path, a.count, "path");
      expectSameBits(a.o.x, b.o.x, a.count, "o");
      expectSameBits(a.d.x, b.d.x, a.count, "d.x");
      expectSameBits(a.d.z, b.d.z, a.count, "d.z");
      expectSameBits(a.t, b.t, a.count, "t");
      expectSameBits(a.mediaFrom, b.mediaFrom, a.count, "mediaFrom");
      expectSameBits(a.mediaTo, b.mediaTo, a.count, "mediaTo");
      expectSameBits(a.uDepth, b.uDepth, a.count, "uDepth");
      expectSameBits(a.mayMeetSurface, b.mayMeetSurface, a.count, "mayMeetSurface");
      expectSameBits(a.isAlive, b.isAlive, a.count, "isAlive");
      for (std::size_t i = 0; i < a.count; ++i) {
        if (!a.collides(i)) continue;
        EXPECT_EQ(a.wi[i], b.wi[i]);
        if (a.isAlive[i] > 0) {
          EXPECT_EQ(a.power[i], b.power[i]);
        }
      }
    }
}

TEST(PathWave, NumbersAreThoseOfTheirPaths) {
  PathWave wave = someWave(100);
  drawNumbers(12, wave);
  for (std::size_t i = 0; i < wave.count; ++i) {
    Rng rng(std::uint64_t{wave.keyHigh[i]} << 32 | wave.keyLow[i], 12);
    EXPECT_EQ(Vec2(wave.uChannel[i], wave.uDepth[i]), rng.uniform2());
    EXPECT_EQ(wave.u1[i], rng.uniform());
    EXPECT_EQ(wave.u2[i], rng.uniform());
    EXPECT_EQ(Vec2(wave.ux[i], wave.uy[i]), rng.uniform2());
  }
}

TEST(PathWave, WhoIsAliveAndWantedStays) {
  const PathWave before = someWave(203);
  PathWave wave = before;
  dropEnded(wave);
  std::size_t n = 0;
  for (std::size_t i = 0; i < before.count; ++i) {
    if (!(before.isAlive[i] > 0) || i % 7 == 0) continue;
    ASSERT_LT(n, wave.count);
    EXPECT_EQ(wave.path[n], i);
    EXPECT_EQ(wave.o[n], before.o[i]);
    EXPECT_EQ(wave.power[n], before.power[i]);
    EXPECT_EQ(wave.keyHigh[n], before.keyHigh[i]);
    EXPECT_EQ(wave.isAlive[n], 1);
    ++n;
  }
  EXPECT_EQ(wave.count, n);
}

TEST(PathWave, SegmentsNearABoxAreFound) {
  // The points of every segment: none inside of the box where it is said to be far.
  const Bounds3 box{Vec3(-0.3f, 0.1f, -0.5f), Vec3(0.9f, 0.1f, 0.2f)};
  PathWave wave = someWave(PathWave::kSize);
  std::size_t far = 0, near = 0;
  for (std::size_t i = 0; i < wave.count; ++i)
    wave.t[i] = i % 4 == 0 ? kInfinity : 0.01f * static_cast<float>(i);
  findSegmentsNear(box, wave);
  for (std::size_t i = 0; i < wave.count; ++i) {
    // Where it crosses the plane of the flat box.
    const float t = (0.1f - wave.o.y[i]) / wave.d.y[i];
    const Vec3 p = wave.o[i] + wave.d[i] * t;
    const bool meets = t >= 0 && t <= wave.t[i] && p.x >= box.lo.x && p.x <= box.hi.x &&
                       p.z >= box.lo.z && p.z <= box.hi.z;
    if (meets) {
      EXPECT_EQ(wave.mayMeetSurface[i], 1u) << i;
    }
    (wave.mayMeetSurface[i] ? near : far) += 1;
  }
  EXPECT_GT(near, 5u);
  EXPECT_GT(far, 150u);
  findSegmentsNear(Bounds3{}, wave);
  for (std::size_t i = 0; i < wave.count; ++i) EXPECT_EQ(wave.mayMeetSurface[i], 0u);
}

TEST(PathWave, ScatteringIsThatOfThePhaseFunction) {
  // As PhotonTracer would do it path by path.
  for (const float g : {0.f, 0.7f, -0.99f}) {
    PathWave wave = someWave(PathWave::kSize);
    drawNumbers(0, wave);
    for (std::size_t i = 0; i < wave.count; ++i) wave.t[i] = i % 2 == 0 ? 0.5f : kInfinity;
    const PathWave before = wave;
    arriveInMedia(wave);
    scatterInMedia(g, 4, wave);
    for (std::size_t i = 0; i < wave.count; ++i) {
      if (i % 2 == 1) {
        EXPECT_EQ(wave.d[i], before.d[i]);
        EXPECT_EQ(wave.o[i], before.o[i]);
        continue;
      }
      const double u = double{before.ux[i]};
      const double cosine =
          g == 0 ? 2 * u - 1
                 : (1 + double{g} * g - sqr((1 - double{g} * g) / (1 - g + 2 * g * u))) / (2 * g);
      EXPECT_NEAR(dot(wave.d[i], before.d[i]), cosine, 2e-6);
      EXPECT_NEAR(length(wave.d[i]), 1, 1e-6);
      EXPECT_EQ(wave.o[i], before.o[i] + before.d[i] * 0.5f);
      EXPECT_EQ(wave.wi[i], PackedDirection(-before.d[i]).bits());
      EXPECT_EQ(wave.canStore[i], 4u);
      EXPECT_EQ(wave.isInMedium[i], 1u);
    }
  }
}

}  // namespace
}  // namespace brume
