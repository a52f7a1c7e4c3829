// SPDX-License-Identifier: Apache-2.0
// Transforms, random numbers, warps and tabulated distributions, parallel loops, statistics.
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

#include "core/parallel.h"
#include "core/rng.h"
#include "core/sampling.h"
#include "core/stats.h"
#include "core/transform.h"

namespace brume {
namespace {

void expectNear(const Vec3& a, const Vec3& b, float tolerance) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "axis " << i;
}

TEST(Transform, RotatesByTheRightHandRule) {
  expectNear(Transform::rotate(90, {0, 0, 1}).vector({1, 0, 0}), {0, 1, 0}, 1e-6f);
  expectNear(Transform::rotate(90, {1, 0, 0}).vector({0, 1, 0}), {0, 0, 1}, 1e-6f);
}

TEST(Transform, LookAtIsLeftHanded) {
  const auto worldToCamera = Transform::lookAt({0, 0, -5}, {0, 0, 0}, {0, 1, 0});
  ASSERT_TRUE(worldToCamera);
  expectNear(worldToCamera->point({0, 0, 0}), {0, 0, 5}, 1e-6f);
  expectNear(worldToCamera->vector({1, 0, 0}), {1, 0, 0}, 1e-6f);
  EXPECT_FALSE(Transform::lookAt({0, 0, 0}, {0, 0, 0}, {0, 1, 0}));
  EXPECT_FALSE(Transform::lookAt({0, 0, 0}, {0, 2, 0}, {0, 1, 0}));
}

TEST(Transform, NormalsStayPerpendicularUnderShear) {
  Mat4d shear(1.0);
  shear[1][0] = 0.7;
  shear[2][2] = 3;
  const Transform t(shear);
  const Vec3 tangent(1, 2, -1), normal(1, 0, 1);  // perpendicular
  EXPECT_NEAR(dot(t.vector(tangent), t.normal(normal)), 0, 1e-6f);
}

TEST(Transform, ErrorBoundHoldsAgainstDouble) {
  Rng rng(1);
  const Transform t = Transform::translate({1e4, -2e3, 17}) * Transform::rotate(33, {1, 2, 3}) *
                      Transform::scale(3, .01, 50);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p(rng.uniform() * 100 - 50, rng.uniform() * 1e4f, rng.uniform() * .01f);
    Vec3 error;
    const Vec3 q = t.point(p, Vec3(0), &error);
    const glm::dvec4 exact = t.matrix() * glm::dvec4(p.x, p.y, p.z, 1);
    for (int a = 0; a < 3; ++a) EXPECT_LE(std::abs(q[a] - exact[a]), error[a]);
  }
}

TEST(Transform, SingularMatricesAreRecognised) {
  EXPECT_TRUE(Transform::isInvertible(Mat4d(1.0)));
  EXPECT_TRUE(Transform::isInvertible(Transform::scale(1e-6, 1e-6, 1e-6).matrix()));
  EXPECT_TRUE(Transform::isInvertible(Transform::scale(1e6, 1, 1).matrix()));
  EXPECT_FALSE(Transform::isInvertible(Transform::scale(1, 0, 1).matrix()));
  Mat4d nan(1.0);
  nan[1][1] = std::nan("");
  EXPECT_FALSE(Transform::isInvertible(nan));
}

TEST(AnimatedTransform, InterpolatesRotationOnTheArc) {
  const AnimatedTransform a(Transform(), 0,
                            Transform::translate({2, 0, 0}) * Transform::rotate(90, {0, 0, 1}), 1);
  ASSERT_TRUE(a.isAnimated());
  expectNear(a.at(.5f).vector({1, 0, 0}), {std::sqrt(.5f), std::sqrt(.5f), 0}, 1e-6f);
  expectNear(a.at(.5f).point({0, 0, 0}), {1, 0, 0}, 1e-6f);
  expectNear(a.at(-1).point({1, 0, 0}), {1, 0, 0}, 0);
  expectNear(a.at(2).point({1, 0, 0}), {2, 1, 0}, 1e-6f);
}

TEST(AnimatedTransform, MirroringEndsAreReproduced) {
  const Transform start = Transform::scale(-1, 1, 1),
                  end = Transform::scale(-2, 1, 1) * Transform::rotate(10, {0, 1, 0});
  const AnimatedTransform a(start, 0, end, 1);
  for (float time : {0.001f, 0.999f}) {
    const Transform& nearest = time < .5f ? start : end;
    expectNear(a.at(time).point({1, 2, 3}), nearest.point({1, 2, 3}),
               5e-3f);  // 0.1 % of a motion of a few units
  }
}

TEST(AnimatedTransform, MotionBoundsHoldEverySampledPoint) {
  const AnimatedTransform a(Transform(), 0, Transform::rotate(170, {0, 0, 1}), 1);
  const Bounds3 box{{1, 0, 0}, {2, .1f, .1f}};
  const Bounds3 swept = a.motionBounds(box);
  for (int i = 0; i <= 1000; ++i)
    for (int c = 0; c < 8; ++c)
      EXPECT_TRUE(swept.contains(a.at(static_cast<float>(i) / 1000).point(box.corner(c))));
}

TEST(Rng, IsAFunctionOfItsKey) {
  Rng a = Rng::forPath(1, 2, 3), b = Rng::forPath(1, 2, 3), c = Rng::forPath(1, 3, 2);
  EXPECT_EQ(a.bits64(), b.bits64());
  EXPECT_NE(a.bits64(), c.bits64());
}

TEST(Rng, IsUniformWithinAndAcrossPaths) {
  constexpr int kBins = 64, kSamples = 1 << 18;
  for (bool across : {false, true}) {
    std::array<int, kBins> counts{};
    Rng one(42);
    for (int i = 0; i < kSamples; ++i) {
      Rng path = Rng::forPath(7, 0, static_cast<std::uint64_t>(i));
      const float u = across ? path.uniform() : one.uniform();
      ASSERT_TRUE(u >= 0 && u < 1);
      ++counts[static_cast<std::size_t>(u * kBins)];
    }
    double chi2 = 0;
    for (int n : counts) chi2 += sqr(n - double{kSamples} / kBins) / (double{kSamples} / kBins);
    EXPECT_LT(chi2, 113);  // 63 degrees of freedom: p = 1e-4
    EXPECT_GT(chi2, 26);   // too even is not random either
  }
}

TEST(Sampling, WarpsKeepTheirMoments) {
  constexpr int n = 512;  // the midpoint rule's error on the square root at the rim is then 5e-5
  double cosine = 0, sphereZ2 = 0, coneCos = 0;
  Vec2 disk(0);
  for (int i = 0; i < n * n; ++i) {
    const Vec2 u((static_cast<float>(i % n) + .5f) / n, (static_cast<float>(i / n) + .5f) / n);
    cosine += sampleCosineHemisphere(u).z;
    sphereZ2 += sqr(sampleUniformSphere(u).z);
    coneCos += sampleUniformCone(u, .5f).z;
    disk += sampleConcentricDisk(u);
  }
  EXPECT_NEAR(cosine / (n * n), 2. / 3, 1e-4);
  EXPECT_NEAR(sphereZ2 / (n * n), 1. / 3, 1e-4);
  EXPECT_NEAR(coneCos / (n * n), .75, 1e-4);
  EXPECT_NEAR(disk.x / (n * n), 0, 1e-4);
}

TEST(Sampling, CosineAndSineOfTurns) {
  constexpr int n = 1 << 18;
  for (int i = 0; i <= n; ++i) {
    const float u = static_cast<float>(i) / n;
    const Vec2 cs = cosSinOfTurns(u);
    ASSERT_NEAR(cs.x, std::cos(2 * M_PI * double{u}), 1.5e-7) << u;
    ASSERT_NEAR(cs.y, std::sin(2 * M_PI * double{u}), 1.5e-7) << u;
  }
}

TEST(Sampling, Distribution1DSamplesItsDensity) {
  const std::vector<float> values{0, 1, 0, 3, 0};
  const Distribution1D d(values);
  EXPECT_FLOAT_EQ(d.pdf(.3f), 1.25f);
  EXPECT_FLOAT_EQ(d.pdf(.7f), 3.75f);
  EXPECT_EQ(d.pdf(.9f), 0.f);
  for (float u : {0.f, .1f, .2499f, .25f, .5f, .9f, kOneMinusEpsilon}) {
    const auto s = d.sample(u);
    EXPECT_GT(s.pdf, 0.f) << u;
    EXPECT_FLOAT_EQ(s.pdf, d.pdf(s.x)) << u;
  }
  const Distribution1D zero(std::vector<float>(4, 0.f));
  EXPECT_FLOAT_EQ(zero.pdf(.5f), 1.f);
}

/// The guide only shortens the search: every number finds the cell that a plain search finds.
TEST(Sampling, Distribution1DFindsTheCellOfAPlainSearch) {
  Rng rng(11);
  for (const std::size_t size : {1, 2, 7, 64, 1000})
    for (const float empty : {0.f, .5f, .99f, 1.f}) {
      SCOPED_TRACE(size);
      std::vector<float> values(size);
      for (float& v : values) v = rng.uniform() < empty ? 0.f : std::exp(12 * rng.uniform());
      const Distribution1D d(values);
      std::vector<double> cdf(size + 1);
      for (std::size_t i = 0; i < size; ++i)
        cdf[i + 1] = cdf[i] + values[i] / static_cast<double>(size);
      for (std::size_t i = 1; i <= size; ++i)
        cdf[i] = d.integral() > 0 ? cdf[i] / d.integral()
                                  : static_cast<double>(i) / static_cast<double>(size);
      for (int k = 0; k < 3000; ++k) {
        // Random ones, and those next to the borders of cells and of equal parts.
        float u = rng.uniform();
        const std::size_t at = rng.below(static_cast<std::uint32_t>(size));
        if (k % 3 == 1) u = static_cast<float>(cdf[at]);
        if (k % 3 == 2) u = static_cast<float>(at) / static_cast<float>(size);
        u = std::min(u, kOneMinusEpsilon);
        const auto after = std::upper_bound(cdf.begin(), cdf.end(), double{u});
        ASSERT_EQ(d.sample(u).index,
                  std::min(size - 1, static_cast<std::size_t>(after - cdf.begin() - 1)));
      }
    }
}

TEST(Sampling, Distribution2DIntegratesToOne) {
  std::vector<float> values(32 * 16);
  Rng rng(3);
  for (float& v : values) v = rng.uniform() < .5f ? 0.f : rng.uniform() * 10;
  const Distribution2D d(values, 32, 16);
  double sum = 0;
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 32; ++x)
      sum += d.pdf({(static_cast<float>(x) + .5f) / 32, (static_cast<float>(y) + .5f) / 16});
  EXPECT_NEAR(sum / (32 * 16), 1, 1e-5);
  for (int i = 0; i < 1000; ++i) {
    const auto s = d.sample(rng.uniform2());
    EXPECT_GT(s.pdf, 0.f);
    EXPECT_FLOAT_EQ(s.pdf, d.pdf(s.p));
  }
}

TEST(Sampling, PowerHeuristicSumsToOneAndDoesNotOverflow) {
  EXPECT_FLOAT_EQ(powerHeuristic(1e30f, 3e30f) + powerHeuristic(3e30f, 1e30f), 1.f);
  EXPECT_FLOAT_EQ(powerHeuristic(1, 3), .1f);
  EXPECT_EQ(powerHeuristic(0, 1), 0.f);
  EXPECT_EQ(powerHeuristic(kInfinity, 1), 1.f);
}

TEST(Parallel, ChunksCoverTheRangeWhateverTheThreads) {
  for (int threads : {1, 2, 7}) {
    setThreadCount(threads);
    std::vector<std::atomic<int>> seen(1001);
    forEachChunk(1001, 10, [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
      EXPECT_EQ(begin, chunk * 10);
      for (auto i = begin; i < end; ++i) ++seen[static_cast<std::size_t>(i)];
    });
    for (const auto& n : seen) EXPECT_EQ(n.load(), 1);
  }
  setThreadCount(0);
}

TEST(Parallel, RethrowsTheFirstException) {
  EXPECT_THROW(forEachChunk(100, 1,
                            [](auto, auto, auto chunk) {
                              if (chunk == 50) throw std::runtime_error("chunk");
                            }),
               std::runtime_error);
}

TEST(Stats, CountFaultsAndKeepThemFromTheFilm) {
  Stats stats;
  EXPECT_EQ(stats.checkRadiance(Rgb(1, 2, 3)), Rgb(1, 2, 3));
  EXPECT_EQ(stats.checkRadiance(Rgb(std::nanf(""), 0, 0)), Rgb());
  EXPECT_EQ(stats.checkRadiance(Rgb(kInfinity)), Rgb());
  stats.checkRadiance(Rgb(-1, 0, 0));
  EXPECT_EQ(stats[Stat::NanRadiance], 1u);
  EXPECT_EQ(stats[Stat::InfiniteRadiance], 1u);
  EXPECT_EQ(stats[Stat::NegativeRadiance], 1u);
}

}  // namespace
}  // namespace brume
