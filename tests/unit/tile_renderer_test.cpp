// SPDX-License-Identifier: Apache-2.0
#include "renderers/tile_renderer.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <thread>

#include "core/parallel.h"
#include "renderers/pass_loop.h"
#include "support/render_text.h"
#include "support/synthetic_image.h"

namespace brume {
namespace {

/// Uniform noise of mean 1/2 in r, the sample's raster x in g, 1 in b.
class NoiseRadiance : public RayRadiance {
 public:
  Rgb Li(const FootprintRay& ray, int, RenderContext& context) const override {
    return {context.samples.get1D(), ray.o.x, 1.f};
  }
};

/// Restores the number of threads.
struct ThreadCount {
  explicit ThreadCount(int n) { setThreadCount(n); }
  ~ThreadCount() { setThreadCount(0); }
};

struct TestRender {
  TestBoxFilter filter{1.5f};  // tiles overlap
  RasterCamera camera;
  NoiseRadiance noise;
  TestSampler sampler;
  Film film;
  std::atomic<bool> stop{false};
  Stats stats;

  explicit TestRender(const TestSampler::Options& options = {}, Vec2i resolution = {70, 45})
      : sampler(options), film(settings(resolution), filter) {}

  static Film::Settings settings(Vec2i resolution) {
    Film::Settings s;
    s.resolution = resolution;
    s.crop = {{0, 0}, resolution};
    s.withVariance = true;
    return s;
  }
  TileRenderParts parts(const RayRadiance& radiance) {
    return {camera, sampler, film, radiance, 7, true};
  }
  bool render(SampleRange range) {
    TileRenderer renderer(parts(noise));
    return renderer.render(range, stop, stats, [](double, const Stats&) {});
  }
  RenderOutcome renderPortions(const RenderLimits& limits, const RayRadiance& radiance) {
    TileRenderer renderer(parts(radiance));
    return brume::renderPortions(renderer, film, limits, stop, stats, {});
  }
};

TEST(TileRenderer, SameBitsForAnyNumberOfThreads) {
  const auto image = [](int threads) {
    const ThreadCount count(threads);
    TestRender setup;
    EXPECT_TRUE(setup.render({0, 4}));
    EXPECT_TRUE(setup.render({4, 7}));
    return setup.film.develop().channels;
  };
  const auto one = image(1);
  EXPECT_EQ(one, image(2));
  EXPECT_EQ(one, image(7));
}

/// Pixels of an uneven pattern differ in one round, not in all.
TEST(TileRenderer, PixelsOfALongRenderGetAsManySamples) {
  constexpr int kPerPixel = 4, kRounds = 32;
  RenderSettings settings;
  settings.variance = true;
  settings.passes = kRounds;
  const RenderResult result = renderText(
      fmt::format("Film \"image\" \"integer xresolution\" 24 \"integer yresolution\" 16 "
                  "PixelFilter \"box\"\n"
                  "Sampler \"bestcandidate\" \"integer pixelsamples\" {}\nWorldBegin\nWorldEnd\n",
                  kPerPixel),
      settings);
  std::set<float> counts;
  for (const float n : result.image.channels.at("samples")) {
    EXPECT_NEAR(n, kPerPixel * kRounds, kPerPixel);
    counts.insert(n);
  }
  EXPECT_GT(counts.size(), 1u);
}

TEST(TileRenderer, EverySampleFallsOnce) {
  TestRender setup;
  setup.render({0, 4});
  // The sampled area is the image and one pixel around it, which the filter of 1.5 pixels reaches.
  const std::int64_t pixels = setup.film.sampleBounds().area();
  EXPECT_EQ(pixels, 72 * 47);
  EXPECT_EQ(setup.stats[Stat::CameraRays], static_cast<std::uint64_t>(4 * pixels));
  const LayeredImage image = setup.film.develop();
  for (const float b : image.channels.at("B")) EXPECT_FLOAT_EQ(b, 1.f);
  // The mean position of the samples of a pixel, 9 pixels of 4 samples with standard deviation
  // sqrt(9/12) = 0.87: 6 sigma of a mean of 36.
  for (int x = 5; x < 65; ++x)
    EXPECT_NEAR(image.channels.at("G")[static_cast<std::size_t>(20 * 70 + x)],
                static_cast<float>(x) + 0.5f, 6 * 0.87 / 6);
}

TEST(TileRenderer, RangesJoinToTheWhole) {
  TestRender whole({5, true}), parts({5, true});
  whole.render({0, 10});
  for (const SampleRange range : {SampleRange{0, 1}, SampleRange{1, 7}, SampleRange{7, 10}})
    parts.render(range);
  EXPECT_EQ(whole.stats[Stat::CameraRays], parts.stats[Stat::CameraRays]);
  const auto a = whole.film.develop().channels, b = parts.film.develop().channels;
  // The same samples in another order: sums in double agree to the last bits of a float.
  for (std::size_t i = 0; i < a.at("R").size(); ++i) EXPECT_NEAR(a.at("R")[i], b.at("R")[i], 1e-6f);
}

TEST(TileRenderer, AdaptiveSamplesReplaceTheFirstOnes) {
  TestRender setup({4, false, 9});
  setup.render({0, 4});
  const std::int64_t pixels = setup.film.sampleBounds().area();
  EXPECT_EQ(setup.stats[Stat::CameraRays], static_cast<std::uint64_t>((4 + 9) * pixels));
  // An inner pixel's filter reaches 9 pixels of 9 samples: the 4 first ones are gone. The box of
  // 1.5 pixels takes exactly those.
  EXPECT_EQ(setup.film.develop().channels.at("samples")[20 * 70 + 30], 81.f);

  // A second round is another one.
  const auto before = setup.film.develop().channels.at("R");
  setup.render({4, 8});
  EXPECT_NE(before, setup.film.develop().channels.at("R"));
}

TEST(TileRenderer, StopKeepsWhatWasSampled) {
  // Stops from within after some samples.
  class Stopping final : public RayRadiance {
   public:
    explicit Stopping(std::atomic<bool>& stop) : stop_(stop) {}
    Rgb Li(const FootprintRay&, int, RenderContext&) const override {
      if (++count_ == 5000) stop_ = true;
      return Rgb(1.f);
    }

   private:
    std::atomic<bool>& stop_;
    mutable std::atomic<int> count_{0};
  };
  TestRender setup;
  const Stopping radiance(setup.stop);
  const RenderOutcome outcome = setup.renderPortions({4, false, 1, {}, {}}, radiance);
  EXPECT_EQ(outcome.reason, StopReason::Interrupted);
  EXPECT_LT(setup.stats[Stat::CameraRays], static_cast<std::uint64_t>(4 * 72 * 47));
  EXPECT_GE(setup.stats[Stat::CameraRays], 5000u);
  std::set<float> values;
  const LayeredImage image = setup.film.develop();
  for (const float r : image.channels.at("R")) values.insert(r);
  EXPECT_EQ(values, (std::set<float>{0.f, 1.f}));  // black where nothing fell, else the whole value
}

TEST(TileRenderer, AnExceptionEndsTheRender) {
  class Failing final : public RayRadiance {
   public:
    Rgb Li(const FootprintRay& ray, int, RenderContext&) const override {
      if (ray.o.x > 40) throw SceneError("fails");
      return Rgb(1.f);
    }
  };
  TestRender setup({1}, {600, 600});  // more tiles than may wait for the first one
  const Failing failing;
  TileRenderer renderer(setup.parts(failing));
  EXPECT_THROW(renderer.render({0, 1}, setup.stop, setup.stats, [](double, const Stats&) {}),
               SceneError);
}

TEST(TileRenderer, FaultyRadianceIsCounted) {
  class Faulty final : public RayRadiance {
   public:
    Rgb Li(const FootprintRay& ray, int, RenderContext&) const override {
      const int x = static_cast<int>(ray.o.x);
      if (x == 3) return Rgb(std::nanf(""));
      if (x == 5) return Rgb(kInfinity);
      return x == 7 ? Rgb(-1.f) : Rgb(1.f);
    }
  };
  TestRender setup({2});
  const Faulty faulty;
  TileRenderer renderer(setup.parts(faulty));
  renderer.render({0, 2}, setup.stop, setup.stats, [](double, const Stats&) {});
  EXPECT_EQ(setup.stats[Stat::NanRadiance], 2u * 47);
  EXPECT_EQ(setup.stats[Stat::InfiniteRadiance], 2u * 47);
  EXPECT_EQ(setup.stats[Stat::NegativeRadiance], 2u * 47);
}

TEST(PassLoop, TakesTheRoundsThatWereAsked) {
  TestRender setup({4}, {20, 20});
  const RenderOutcome outcome = setup.renderPortions({4, false, 9, {}, {}}, setup.noise);
  EXPECT_EQ(outcome.reason, StopReason::Done);
  EXPECT_EQ(outcome.samples, 36);
  EXPECT_EQ(setup.stats[Stat::CameraRays], 36u * 22 * 22);
}

TEST(PassLoop, StopsAtTheTimeLimit) {
  class Slow final : public RayRadiance {
   public:
    Rgb Li(const FootprintRay&, int, RenderContext&) const override {
      const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(2);
      while (std::chrono::steady_clock::now() < end) {
      }
      return Rgb(1.f);
    }
  };
  TestRender setup({4}, {20, 20});
  const RenderOutcome outcome = setup.renderPortions({4, false, {}, 0.1, {}}, Slow{});
  EXPECT_EQ(outcome.reason, StopReason::Time);
  EXPECT_GE(outcome.seconds, 0.1);
  // One sample per pixel takes 1 ms; no portion is longer than half of what was left. The bound
  // leaves room for a busy machine.
  EXPECT_LT(outcome.seconds, 1.0);
  EXPECT_GT(outcome.samples, 1);
}

TEST(PassLoop, StopsAtTheTargetError) {
  TestRender setup({4}, {20, 20});
  const RenderOutcome outcome = setup.renderPortions({4, false, {}, {}, 0.02}, setup.noise);
  EXPECT_EQ(outcome.reason, StopReason::Error);
  ASSERT_TRUE(outcome.estimatedError.has_value());
  EXPECT_LE(*outcome.estimatedError, 0.02);
  // Of the three channels b has no variance, and g is dominated by r: uniform noise has the
  // relative variance 1/3, a pixel takes the samples of 9, its estimate is measured to some per
  // cent. error^2 >= (1/3) (1/3) / (9 n) for red alone gives n = 31 samples per pixel.
  EXPECT_GE(outcome.samples, 25);
  EXPECT_LE(outcome.samples, 80);
}

TEST(PassLoop, ShowsSnapshotsAtGrowingIntervals) {
  TestRender setup({10}, {20, 20}), plain({10}, {20, 20});
  TileRenderer renderer(setup.parts(setup.noise)), plainRenderer(plain.parts(plain.noise));
  std::vector<std::int64_t> samples;
  double inSnapshots = 0;
  LayeredImage last;
  RenderWatch watch;
  watch.snapshot = [&](const RenderOutcome& soFar) {
    samples.push_back(soFar.samples);
    EXPECT_EQ(setup.stats[Stat::CameraRays] % static_cast<std::uint64_t>(soFar.samples), 0u);
    last = setup.film.develop();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    inSnapshots += 0.02;
  };
  const RenderLimits limits{10, false, 2, {}, {}};
  const auto begin = std::chrono::steady_clock::now();
  const RenderOutcome outcome =
      renderPortions(renderer, setup.film, limits, setup.stop, setup.stats, watch);
  const std::chrono::duration<double> all = std::chrono::steady_clock::now() - begin;
  renderPortions(plainRenderer, plain.film, limits, plain.stop, plain.stats, {});

  EXPECT_EQ(samples, (std::vector<std::int64_t>{1, 2, 3, 5, 8, 12, 17}));
  EXPECT_EQ(outcome.samples, 20);
  EXPECT_LE(outcome.seconds, all.count() - inSnapshots) << "snapshots count as rendering";
  // The same samples as without, added up in other portions: doubles differ in the last bits.
  const LayeredImage image = setup.film.develop(), expected = plain.film.develop();
  for (const auto& [name, values] : expected.channels)
    for (std::size_t i = 0; i < values.size(); ++i)
      ASSERT_NEAR(image.channels.at(name)[i], values[i], 1e-5f * std::abs(values[i]) + 1e-9f);
  EXPECT_NE(last.channels.at("samples"), image.channels.at("samples"));
}

TEST(PassLoop, ReportsProgress) {
  // Holds up the first camera ray until a report is due.
  class SlowStart final : public RayRadiance {
   public:
    Rgb Li(const FootprintRay&, int, RenderContext&) const override {
      if (!begun_.exchange(true)) std::this_thread::sleep_for(std::chrono::milliseconds(300));
      return Rgb(1.f);
    }

   private:
    mutable std::atomic<bool> begun_{false};
  };
  TestRender setup({10}, {40, 40});
  const SlowStart radiance;
  TileRenderer renderer(setup.parts(radiance));
  int reports = 0;
  RenderWatch watch;
  watch.progress = [&](const RenderProgress& p) {
    EXPECT_GT(p.fraction, 0.0);
    EXPECT_LE(p.fraction, 1.0);
    EXPECT_GE(p.seconds, 0.25);
    EXPECT_EQ(p.pass, 1);
    ++reports;
  };
  renderPortions(renderer, setup.film, {10, false, 1, {}, {}}, setup.stop, setup.stats, watch);
  EXPECT_EQ(reports, 1);  // a quarter of a second apart
}

}  // namespace
}  // namespace brume
