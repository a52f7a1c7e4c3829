// SPDX-License-Identifier: Apache-2.0
#include "core/sampler.h"

#include <gmock/gmock.h>

#include <set>

#include "core/best_candidate.h"
#include "core/lowdiscrepancy.h"
#include "support/make_plugin.h"

namespace brume {
namespace {

using namespace test;

const char* const kNames[] = {"lowdiscrepancy", "stratified", "halton",
                              "random",         "adaptive",   "bestcandidate"};

std::unique_ptr<Sampler> makeSampler(const char* name, std::vector<Param> params = {},
                                     Sampler::FactoryContext context = {}) {
  context.pixels = {{0, 0}, {64, 64}};
  return make<Sampler>(name, std::move(params), context);
}

/// Every elementary interval of volume 1/n in base 2 holds exactly one of the n points.
void expectNet(const std::vector<Vec2>& points, const std::string& what) {
  const int n = static_cast<int>(points.size());
  for (int nx = 1; nx <= n; nx *= 2) {
    const int ny = n / nx;
    std::set<std::pair<int, int>> cells;
    for (const Vec2& p : points)
      cells.insert({static_cast<int>(p.x * static_cast<float>(nx)),
                    static_cast<int>(p.y * static_cast<float>(ny))});
    EXPECT_EQ(static_cast<int>(cells.size()), n) << what << ", " << nx << " x " << ny;
  }
}

/// Every stratum of length 1/n holds exactly one of the n values.
void expectStrata(const std::vector<float>& values, const std::string& what) {
  std::set<int> strata;
  for (float v : values) strata.insert(static_cast<int>(v * static_cast<float>(values.size())));
  EXPECT_EQ(strata.size(), values.size()) << what;
}

TEST(Sampler, AllValuesLieInTheirIntervals) {
  for (const char* name : kNames) {
    const auto sampler = makeSampler(name);
    const auto stream = sampler->makePixelSampler(7);
    for (const Vec2i& pixel : {Vec2i(0, 0), Vec2i(-3, -1), Vec2i(8191, 65535), Vec2i(1 << 20, 3)}) {
      const int count = stream->startPixel(pixel);
      EXPECT_GE(count, 1) << name;
      for (int i = 0; i < 2 * count + 40; ++i) {
        const CameraSample sample = stream->startSample(i);
        EXPECT_EQ(Vec2i(std::floor(sample.raster.x), std::floor(sample.raster.y)), pixel) << name;
        const auto inside = [](float v) { return v >= 0 && v < 1; };
        EXPECT_TRUE(inside(sample.lens.x) && inside(sample.lens.y) && inside(sample.time)) << name;
        std::vector<float> values(5);
        std::vector<Vec2> points(3);
        for (int d = 0; d < 20; ++d) {
          stream->get1DArray(values);
          stream->get2DArray(points);
          values[0] += 0;
          for (float v : values) EXPECT_TRUE(inside(v)) << name;
          for (const Vec2& p : points) EXPECT_TRUE(inside(p.x) && inside(p.y)) << name;
          const Vec2 u = stream->get2D();
          EXPECT_TRUE(inside(u.x) && inside(u.y) && inside(stream->get1D())) << name;
        }
      }
    }
  }
}

/// Everything that one sample yields, as one list.
std::vector<float> drawSample(PixelSampler& stream, int index) {
  const CameraSample s = stream.startSample(index);
  std::vector<float> all{s.raster.x, s.raster.y, s.lens.x, s.lens.y, s.time};
  std::vector<Vec2> points(4);
  stream.get2DArray(points);
  for (int d = 0; d < 25; ++d) points.push_back(stream.get2D());
  for (const Vec2& p : points) all.insert(all.end(), {p.x, p.y});
  for (int d = 0; d < 20; ++d) all.push_back(stream.get1D());
  return all;
}

TEST(Sampler, DependsOnSeedPixelAndIndexOnly) {
  for (const char* name : kNames) {
    const auto sampler = makeSampler(name);
    const auto a = sampler->makePixelSampler(1), b = sampler->makePixelSampler(1);
    const auto other = sampler->makePixelSampler(2);
    a->startPixel({5, 6});
    const std::vector<float> expected = drawSample(*a, 3);
    // Another history, the same values.
    b->startPixel({50, 60});
    drawSample(*b, 0);
    b->startPixel({5, 6});
    drawSample(*b, 7);
    EXPECT_EQ(drawSample(*b, 3), expected) << name;
    // Another seed, pixel or index: hardly a value in common (24 bits each).
    other->startPixel({5, 6});
    std::vector<std::vector<float>> others{drawSample(*other, 3), drawSample(*a, 2)};
    a->startPixel({6, 5});
    others.push_back(drawSample(*a, 3));
    for (const std::vector<float>& v : others) {
      int same = 0;
      for (std::size_t i = 0; i < v.size(); ++i) same += v[i] == expected[i];
      EXPECT_LE(same, 2) << name;
    }
  }
}

TEST(Sampler, EachDimensionIsUniformAndPairsAreUncorrelated) {
  constexpr int kBins = 16, kDimensions = 44, kPixels = 32;
  for (const char* name : kNames) {
    const auto sampler = makeSampler(name);
    const auto stream = sampler->makePixelSampler(11);
    std::vector<std::vector<float>> values(kDimensions);
    for (int y = 0; y < kPixels; ++y)
      for (int x = 0; x < kPixels; ++x) {
        const int count = stream->startPixel({x, y});
        for (int i = 0; i < count; ++i) {
          const CameraSample s = stream->startSample(i);
          std::size_t d = 0;
          for (float v : {s.raster.x - static_cast<float>(x), s.raster.y - static_cast<float>(y),
                          s.lens.x, s.lens.y, s.time})
            values[d++].push_back(v);
          while (d < kDimensions - 1) {
            const Vec2 u = stream->get2D();
            values[d++].push_back(u.x);
            values[d++].push_back(u.y);
          }
          values[d++].push_back(stream->get1D());
        }
      }
    for (int d = 0; d < kDimensions; ++d) {
      const std::vector<float>& v = values[static_cast<std::size_t>(d)];
      const double n = static_cast<double>(v.size()), expected = n / kBins;
      std::vector<double> histogram(kBins);
      for (float u : v) histogram[static_cast<std::size_t>(u * kBins)] += 1;
      double chiSquare = 0;
      for (double h : histogram) chiSquare += sqr(h - expected) / expected;
      // 15 degrees of freedom: above 50 once in 100,000 for independent numbers, less for strata.
      EXPECT_LT(chiSquare, 50) << name << " dimension " << d;
      for (int e = 0; e < d; ++e) {
        const std::vector<float>& w = values[static_cast<std::size_t>(e)];
        double covariance = 0;
        for (std::size_t i = 0; i < v.size(); ++i)
          covariance += (static_cast<double>(v[i]) - 0.5) * (static_cast<double>(w[i]) - 0.5) / n;
        // Standard deviation 1/sqrt(n) for independent numbers; 946 pairs in 6 samplers.
        EXPECT_LT(std::abs(12 * covariance), 5.5 / std::sqrt(n)) << name << " " << d << " " << e;
      }
    }
  }
}

TEST(Sampler, LowDiscrepancyIsANetInEveryDimension) {
  for (int n : {1, 4, 16, 64}) {
    const auto sampler = makeSampler("lowdiscrepancy", {integers("pixelsamples", {n})});
    const auto stream = sampler->makePixelSampler(3);
    EXPECT_EQ(stream->startPixel({2, 9}), n);
    for (int round = 0; round < 2; ++round) {  // the next n samples are a net again
      std::vector<Vec2> image, lens;
      std::vector<float> time;
      std::vector<std::vector<Vec2>> dimensions(29);
      for (int i = round * n; i < (round + 1) * n; ++i) {
        const CameraSample s = stream->startSample(i);
        image.push_back(s.raster - Vec2(2, 9));
        lens.push_back(s.lens);
        time.push_back(s.time);
        for (std::vector<Vec2>& d : dimensions) d.push_back(stream->get2D());
      }
      expectNet(image, "image");
      expectNet(lens, "lens");
      expectStrata(time, "time");
      for (const std::vector<Vec2>& d : dimensions) expectNet(d, "dimension");
    }
  }
}

/// Sixteen shifts of a pixel are one random number plus multiples of 1/16, on the circle.
TEST(Sampler, ShiftsAreEvenlySpaced) {
  for (const char* name : {"lowdiscrepancy", "halton"}) {
    const auto stream = makeSampler(name, {integers("pixelsamples", {16})})->makePixelSampler(3);
    std::set<float> offsets;
    for (int x = 0; x < 8; ++x) {
      stream->startPixel({x, 1});
      std::set<int> strata;
      float offset = -1;
      for (int i = 0; i < 16; ++i) {
        stream->startSample(i);
        stream->get2D();
        const float scaled = 16 * stream->getShift();
        const float rest = scaled - std::floor(scaled);
        if (i == 0) offset = rest;
        EXPECT_NEAR(rest, offset, 16 * 0x1p-23) << name;  // values are rounded to 24 bits
        strata.insert(static_cast<int>(scaled));
      }
      EXPECT_EQ(strata.size(), 16u) << name;
      offsets.insert(offset);
    }
    EXPECT_EQ(offsets.size(), 8u) << name;
  }
}

TEST(Sampler, ArraysAreStratifiedInThemselvesAndOverThePixel) {
  for (const char* name : {"lowdiscrepancy", "halton", "bestcandidate", "adaptive", "stratified"}) {
    const auto sampler = makeSampler(name);
    const auto stream = sampler->makePixelSampler(3);
    stream->startPixel({1, 1});
    std::vector<float> allX, allY, all1D;
    std::vector<Vec2> points(8);
    std::vector<float> values(8);
    for (int i = 0; i < 4; ++i) {
      stream->startSample(i);
      stream->get2DArray(points);
      stream->get1DArray(values);
      std::vector<float> x, y;
      for (const Vec2& p : points) x.push_back(p.x), y.push_back(p.y);
      expectStrata(x, name);
      expectStrata(y, name);
      expectStrata(values, name);
      allX.insert(allX.end(), x.begin(), x.end());
      allY.insert(allY.end(), y.begin(), y.end());
      all1D.insert(all1D.end(), values.begin(), values.end());
    }
    expectStrata(allX, name);
    expectStrata(allY, name);
    expectStrata(all1D, name);
  }
}

TEST(Sampler, StratifiedHasOneSamplePerStratum) {
  const auto sampler =
      makeSampler("stratified", {integers("xsamples", {3}), integers("ysamples", {5})});
  EXPECT_EQ(sampler->samplesPerPixel(), 15);
  const auto stream = sampler->makePixelSampler(3);
  stream->startPixel({4, 4});
  for (int round = 0; round < 2; ++round) {
    std::set<std::pair<int, int>> image, lens, dimension;
    std::vector<float> time, value;
    const auto cell = [](Vec2 u) {
      return std::pair(static_cast<int>(u.x * 3), static_cast<int>(u.y * 5));
    };
    for (int i = 15 * round; i < 15 * (round + 1); ++i) {
      const CameraSample s = stream->startSample(i);
      image.insert(cell(s.raster - Vec2(4)));
      lens.insert(cell(s.lens));
      time.push_back(s.time);
      dimension.insert(cell(stream->get2D()));
      value.push_back(stream->get1D());
    }
    EXPECT_EQ(image.size(), 15u);
    EXPECT_EQ(lens.size(), 15u);
    EXPECT_EQ(dimension.size(), 15u);
    expectStrata(time, "time");
    expectStrata(value, "dimension");
  }
  const auto regular = makeSampler("stratified", {boolean("jitter", false)});
  const auto centres = regular->makePixelSampler(3);
  centres->startPixel({0, 0});
  EXPECT_EQ(centres->startSample(0).raster, Vec2(0.25f, 0.25f));
  EXPECT_EQ(centres->startSample(3).raster, Vec2(0.75f, 0.75f));
}

TEST(Sampler, HaltonKeepsItsElementaryIntervals) {
  const auto sampler = makeSampler("halton", {integers("pixelsamples", {36})});
  const auto stream = sampler->makePixelSampler(3);
  for (int x = 0; x < 10; ++x) {
    EXPECT_EQ(stream->startPixel({x, 1}), 36);
    std::set<std::pair<int, int>> image, lens;
    for (int i = 0; i < 36; ++i) {
      const Vec2 u = stream->startSample(i).raster - Vec2(x, 1);
      image.insert({static_cast<int>(u.x * 4), static_cast<int>(u.y * 9)});
      const Vec2 l = stream->startSample(i).lens;
      if (i < 35) lens.insert({static_cast<int>(l.x * 5), static_cast<int>(l.y * 7)});
    }
    EXPECT_EQ(image.size(), 36u);
    EXPECT_EQ(lens.size(), 35u);
  }
}

TEST(Sampler, RadicalInverseWithoutShift) {
  EXPECT_FLOAT_EQ(shiftedRadicalInverse(2, 1, 0), 0.5f);
  EXPECT_FLOAT_EQ(shiftedRadicalInverse(2, 6, 0), 0.375f);
  EXPECT_FLOAT_EQ(shiftedRadicalInverse(3, 5, 0), 2.f / 3 + 1.f / 9);
  EXPECT_FLOAT_EQ(shiftedRadicalInverse(11, 0, 0x80000000u), 0.5f);
  EXPECT_LT(shiftedRadicalInverse(2, 0xffffffffu, 0), 1);
}

TEST(Sampler, PermutedIndexIsAPermutation) {
  for (std::uint32_t n : {1u, 2u, 3u, 7u, 64u, 100u, 4096u})
    for (std::uint32_t seed : {0u, 1u, 0xdeadbeefu}) {
      std::set<std::uint32_t> seen;
      for (std::uint32_t i = 0; i < n; ++i) seen.insert(permutedIndex(i, n, seed));
      EXPECT_EQ(seen.size(), n);
      EXPECT_LT(*seen.rbegin(), n);
    }
}

TEST(BestCandidatePattern, PointsKeepTheirDistance) {
  const BestCandidatePattern pattern;
  const auto& points = pattern.points();
  ASSERT_EQ(points.size(), 4096u);
  const auto torus = [](float d) { return std::min(std::abs(d), 1 - std::abs(d)); };
  float smallest = 1;
  double timeGap = 0, lensGap = 0;
  for (const auto& p : points) {
    float nearest = 1, time = 0, lens = 0;
    for (const auto& q : points) {
      const float d =
          sqr(torus(p.position.x - q.position.x)) + sqr(torus(p.position.y - q.position.y));
      if (&p == &q || d >= nearest) continue;
      nearest = d;
      time = torus(p.time - q.time);
      lens = std::sqrt(sqr(torus(p.lens.x - q.lens.x)) + sqr(torus(p.lens.y - q.lens.y)));
    }
    smallest = std::min(smallest, nearest);
    timeGap += static_cast<double>(time) / 4096;
    lensGap += static_cast<double>(lens) / 4096;
  }
  // Random points would come as near as 0.0002; a square lattice is 1/64 apart.
  EXPECT_GT(std::sqrt(smallest), 0.5f / 64);
  // Independent values differ by 0.25 and 0.383 on average; neighbours here differ more.
  EXPECT_GT(timeGap, 0.28);
  EXPECT_GT(lensGap, 0.41);
  std::vector<float> times, lensX, lensY;
  for (const auto& p : points) {
    times.push_back(p.time);
    lensX.push_back(p.lens.x);
    lensY.push_back(p.lens.y);
  }
  expectStrata(times, "time");
  expectStrata(lensX, "lens x");
  expectStrata(lensY, "lens y");
}

TEST(Sampler, BestCandidateTilesTheImage) {
  const auto sampler = makeSampler("bestcandidate", {integers("pixelsamples", {4})});
  const auto stream = sampler->makePixelSampler(3);
  // A tile is 32 pixels wide: any window of its size holds each point of the pattern once.
  std::vector<Vec2> positions;
  for (int y = -7; y < 25; ++y)
    for (int x = 40; x < 72; ++x) {
      const int count = stream->startPixel({x, y});
      for (int i = 0; i < count; ++i) {
        positions.push_back(stream->startSample(i).raster);
        EXPECT_EQ(Vec2i(std::floor(positions.back().x), std::floor(positions.back().y)),
                  Vec2i(x, y));
      }
    }
  EXPECT_EQ(positions.size(), 4096u);
  // Pixels and tiles meet without a seam: points keep their distance everywhere.
  float nearest = 1;
  for (const Vec2& p : positions)
    for (const Vec2& q : positions)
      if (&p != &q) nearest = std::min(nearest, dot(p - q, p - q));
  EXPECT_GT(std::sqrt(nearest), 0.25f);

  // Densities that tiles and pixels do not share.
  for (int n : {1, 5, 300, 5000}) {
    const auto other = makeSampler("bestcandidate", {integers("pixelsamples", {n})});
    const auto s = other->makePixelSampler(1);
    double total = 0;
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 24; ++x) total += s->startPixel({x, y});
    // The empty pixels at n = 1 get a sample more.
    EXPECT_NEAR(total / 576 / n, 1, n == 1 ? 0.2 : 0.02) << n;
  }
}

TEST(Sampler, AdaptiveAsksForMoreWhereThereIsContrast) {
  const auto sampler = makeSampler("adaptive");
  EXPECT_TRUE(sampler->isAdaptive());
  const auto stream = sampler->makePixelSampler(3);
  EXPECT_EQ(stream->startPixel({1, 1}), 4);
  const auto with = [](std::vector<float> L) {
    std::vector<Rgb> rgb;
    for (float l : L) rgb.emplace_back(l);
    return rgb;
  };
  EXPECT_EQ(stream->refine(with({1, 1.4f, 1, 0.7f})), 0);
  EXPECT_EQ(stream->refine(with({0, 0, 0, 0})), 0);
  const CameraSample first = stream->startSample(0);
  EXPECT_EQ(stream->refine(with({1, 1, 1, 4})), 32);
  EXPECT_NE(stream->startSample(0).raster, first.raster);  // all anew
  EXPECT_EQ(stream->refine(with({1, 1, 1, 4})), 0);        // but once only
  EXPECT_EQ(stream->startPixel({1, 1}), 4);
  EXPECT_EQ(stream->startSample(0).raster, first.raster);
}

TEST(Sampler, CountsAreRoundedWithAWarning) {
  const auto countWith = [](const char* name, std::vector<Param> params,
                            const Sampler::FactoryContext& context = {}) {
    return makeSampler(name, std::move(params), context)->samplesPerPixel();
  };
  const int before = captureLog().warningCount();
  EXPECT_EQ(countWith("lowdiscrepancy", {integers("pixelsamples", {5})}), 8);
  EXPECT_EQ(countWith("adaptive", {integers("minsamples", {3}), integers("maxsamples", {9})}), 16);
  EXPECT_EQ(countWith("adaptive", {integers("minsamples", {8}), integers("maxsamples", {8})}), 16);
  EXPECT_EQ(countWith("adaptive", {integers("minsamples", {64})}), 64);  // exchanged
  EXPECT_EQ(countWith("adaptive", {string("method", "shapeid")}), 32);
  EXPECT_EQ(captureLog().warningCount(), before + 5);
  EXPECT_EQ(countWith("halton", {integers("pixelsamples", {5})}), 5);
  EXPECT_EQ(countWith("bestcandidate", {integers("pixelsamples", {5})}), 5);
  EXPECT_EQ(countWith("random", {integers("pixelsamples", {5})}), 5);
  EXPECT_EQ(captureLog().warningCount(), before + 5);
  EXPECT_EQ(makeSampler("lowdiscrepancy")->roundCount(17), 32);
  EXPECT_EQ(makeSampler("halton")->roundCount(17), 17);

  Sampler::FactoryContext quick;
  quick.quick = true;
  const int expected[] = {1, 1, 1, 4, 4, 1};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(countWith(kNames[i], {}, quick), expected[i]);
  quick.samplesPerPixel = 12;
  const int wanted[] = {16, 12, 12, 12, 16, 12};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(countWith(kNames[i], {}, quick), wanted[i]);
}

TEST(Sampler, EndsOfTheRanges) {
  for (const char* name : {"lowdiscrepancy", "halton", "random", "bestcandidate"}) {
    EXPECT_THROW(makeSampler(name, {integers("pixelsamples", {0})}), SceneError) << name;
    EXPECT_THROW(makeSampler(name, {integers("pixelsamples", {-4})}), SceneError) << name;
    EXPECT_THROW(makeSampler(name, {integers("pixelsamples", {(1 << 24) + 1})}), SceneError);
    const int most = std::string(name) == "bestcandidate" ? 1 << 16 : 1 << 24;
    const auto sampler = makeSampler(name, {integers("pixelsamples", {most})});
    const auto stream = sampler->makePixelSampler(1);
    EXPECT_NEAR(stream->startPixel({1, 1}), most, 0.01 * most) << name;
    stream->startSample(most - 1);
    EXPECT_EQ(makeSampler(name, {integers("pixelsamples", {1})})->samplesPerPixel(), 1);
  }
  for (const char* name : kNames)
    for (int spp : {0, -1, (1 << 24) + 1}) {
      Sampler::FactoryContext context;
      context.samplesPerPixel = spp;
      EXPECT_THROW(makeSampler(name, {}, context), SceneError) << name;
    }
  for (const char* param : {"xsamples", "ysamples"}) {
    EXPECT_THROW(makeSampler("stratified", {integers(param, {0})}), SceneError);
    EXPECT_THROW(makeSampler("stratified", {integers(param, {4097})}), SceneError);
  }
  EXPECT_EQ(makeSampler("stratified", {integers("xsamples", {4096}), integers("ysamples", {4096})})
                ->samplesPerPixel(),
            1 << 24);
  EXPECT_THROW(makeSampler("adaptive", {integers("minsamples", {0})}), SceneError);
  EXPECT_EQ(makeSampler("adaptive", {integers("maxsamples", {1 << 24})})->samplesPerPixel(),
            1 << 24);
}

}  // namespace
}  // namespace brume
