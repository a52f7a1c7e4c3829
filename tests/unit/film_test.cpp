// SPDX-License-Identifier: Apache-2.0
#include "core/film.h"

#include <gmock/gmock.h>

#include <utility>

#include "core/rng.h"
#include "support/make_plugin.h"

namespace brume {
namespace {

using namespace test;
using testing::HasSubstr;

Film makeFilm(const Filter& filter, Vec2i resolution, const Bounds2i& crop, bool variance = false) {
  Film::Settings settings;
  settings.resolution = resolution;
  settings.crop = crop;
  settings.withVariance = variance;
  return {settings, filter};
}

std::unique_ptr<Film> makeImage(std::vector<Param> params, Film::FactoryContext context = {}) {
  static const auto box = make<Filter>("box", {});
  context.filter = box.get();
  return make<Film>("image", std::move(params), context);
}

/// Random samples over all sample positions of a film, tile by tile.
void fill(Film& film, int perPixel, int tileSize, const std::function<Rgb(Vec2)>& radiance) {
  const Bounds2i all = film.sampleBounds();
  for (int y0 = all.lo.y; y0 < all.hi.y; y0 += tileSize)
    for (int x0 = all.lo.x; x0 < all.hi.x; x0 += tileSize) {
      const Bounds2i part{{x0, y0},
                          {std::min(x0 + tileSize, all.hi.x), std::min(y0 + tileSize, all.hi.y)}};
      FilmTile tile = film.makeTile(part);
      for (int y = part.lo.y; y < part.hi.y; ++y)
        for (int x = part.lo.x; x < part.hi.x; ++x) {
          Rng rng(hashIntegers(x + 1000, y + 1000));
          for (int i = 0; i < perPixel; ++i) {
            const Vec2 p = Vec2(x, y) + rng.uniform2();
            tile.addSample(p, radiance(p));
          }
        }
      film.merge(tile);
    }
}

TEST(Film, ConstantStaysConstantUnderEveryFilter) {
  for (const char* name : {"box", "triangle", "gaussian", "mitchell", "sinc"})
    for (float width : {0.5f, 1.3f, 2.f, 4.f}) {
      const auto filter =
          make<Filter>(name, {floats("xwidth", {width}), floats("ywidth", {width})});
      Film film = makeFilm(*filter, {9, 7}, {{2, 1}, {8, 6}}, true);
      fill(film, 3, 4, [](Vec2) { return Rgb(0.1f, 2, 30); });
      const LayeredImage image = film.develop();
      for (std::size_t i = 0; i < 30; ++i) {
        EXPECT_FLOAT_EQ(image.channels.at("R")[i], 0.1f) << name << width;
        EXPECT_FLOAT_EQ(image.channels.at("G")[i], 2) << name << width;
        EXPECT_FLOAT_EQ(image.channels.at("B")[i], 30) << name << width;
        // Sums in double: the variance of a constant is rounding only.
        EXPECT_NEAR(image.channels.at("variance.B")[i], 0, 1e-9) << name << width;
      }
    }
}

TEST(Film, TilesGiveTheSumsOfTheWhole) {
  const auto filter = make<Filter>("mitchell", {});
  const auto radiance = [](Vec2 p) { return Rgb(p.x, p.y, p.x * p.y); };
  Film whole = makeFilm(*filter, {20, 20}, {{0, 0}, {20, 20}});
  Film tiles = makeFilm(*filter, {20, 20}, {{0, 0}, {20, 20}});
  fill(whole, 4, 100, radiance);
  fill(tiles, 4, 5, radiance);
  const LayeredImage a = whole.develop(), b = tiles.develop();
  for (const char* c : {"R", "G", "B"})
    for (std::size_t i = 0; i < 400; ++i) EXPECT_FLOAT_EQ(a.channels.at(c)[i], b.channels.at(c)[i]);
}

TEST(Film, BoxGivesEachSampleToOnePixel) {
  const auto box = make<Filter>("box", {});
  Film film = makeFilm(*box, {4, 4}, {{0, 0}, {4, 4}}, true);
  EXPECT_EQ(film.sampleBounds().lo, Vec2i(0));
  EXPECT_EQ(film.sampleBounds().hi, Vec2i(4));
  FilmTile tile = film.makeTile({{0, 0}, {4, 4}});
  // Corners belong to the pixel that begins there; the far border belongs to nobody.
  for (int y = 0; y <= 4; ++y)
    for (int x = 0; x <= 4; ++x) tile.addSample(Vec2(x, y), Rgb(1));
  tile.addSample({std::nextafter(4.f, 0.f), 0}, Rgb(1));
  tile.addSample({-1e-9f, 0}, Rgb(1));
  film.merge(tile);
  const LayeredImage image = film.develop();
  for (std::size_t i = 0; i < 16; ++i)
    EXPECT_EQ(image.channels.at("samples")[i], i == 3 ? 2.f : 1.f) << i;
}

TEST(Film, SampleBoundsReachAsFarAsTheFilter) {
  for (float width : {0.2f, 0.5f, 0.6f, 1.f, 1.5f, 2.f, 3.7f}) {
    const auto filter = make<Filter>("box", {floats("xwidth", {width}), floats("ywidth", {width})});
    const Bounds2i crop{{3, 5}, {7, 11}};
    const Film film = makeFilm(*filter, {20, 20}, crop, true);
    const Bounds2i samples = film.sampleBounds();
    EXPECT_EQ(samples.lo.x, std::floor(3 + 0.5 - static_cast<double>(width)));
    EXPECT_EQ(samples.hi.y, std::ceil(11 - 0.5 + static_cast<double>(width)));
    // A tile of one sample pixel holds every pixel that any of its samples reaches, no more.
    for (int x = samples.lo.x; x < samples.hi.x; ++x) {
      const FilmTile tile = film.makeTile({{x, 6}, {x + 1, 7}});
      int lo = 100, hi = -100;
      for (int k = 0; k <= 1000; ++k) {
        const double sx = std::min(
            x + k / 1000.0, static_cast<double>(std::nextafter(static_cast<float>(x + 1), -1e9f)));
        for (int p = crop.lo.x; p < crop.hi.x; ++p)
          if (p + 0.5 - static_cast<double>(width) <= sx &&
              sx < p + 0.5 + static_cast<double>(width)) {
            lo = std::min(lo, p);
            hi = std::max(hi, p + 1);
          }
      }
      if (lo < hi) {
        EXPECT_EQ(tile.pixels().lo.x, lo) << width << " " << x;
        EXPECT_EQ(tile.pixels().hi.x, hi) << width << " " << x;
      }
    }
  }
}

TEST(Film, VarianceIsThatOfTheMean) {
  const auto box = make<Filter>("box", {});
  Film film = makeFilm(*box, {64, 64}, {{0, 0}, {64, 64}}, true);
  fill(film, 16, 16, [](Vec2 p) { return Rgb(p.x - std::floor(p.x)); });
  const LayeredImage image = film.develop();
  double variance = 0, spread = 0;
  for (std::size_t i = 0; i < 4096; ++i) {
    variance += image.channels.at("variance.G")[i] / 4096;
    spread += sqr(static_cast<double>(image.channels.at("G")[i]) - 0.5) / 4096;
  }
  // Uniform numbers: 1/12/16. Relative standard error of `variance` about 0.4 %, of `spread` 2.2 %.
  EXPECT_NEAR(variance * 192, 1, 0.02);
  EXPECT_NEAR(spread * 192, 1, 0.1);
  // E[1/(v^2 + c)] with v around 0.5, c = 0.01 mean^2, to second order in the spread of v.
  const double c = 0.0025, d = 0.25 + c,
               mean = 1 / d + 0.5 * (6 * 0.25 - 2 * c) / (d * d * d) / 192;
  EXPECT_NEAR(film.estimatedRelativeError(), std::sqrt(mean / 192), 0.002);
}

TEST(Film, SumsOfManyPassesDoNotDrift) {
  // Three million passes of one pixel, with rare values a million times the common ones, against
  // sums in long double (64 bits of mantissa): the result, a float, has the same bits.
  const auto box = make<Filter>("box", {});
  Film film = makeFilm(*box, {1, 1}, {{0, 0}, {1, 1}});
  FilmTile tile = film.makeTile(film.sampleBounds());
  Rng rng(4);
  long double sum[3] = {};
  constexpr int kPasses = 3'000'000;
  for (int i = 0; i < kPasses; ++i) {
    const float rare = rng.uniform() < 1e-5f ? 1e6f : 1.f;
    const Rgb L(rng.uniform() * rare, 1e-3f * rng.uniform(), 0.1f);
    for (int c = 0; c < 3; ++c) sum[c] += static_cast<long double>(L[c]);
    tile.addSample(Vec2(0.5f), L);
  }
  film.merge(tile);
  const LayeredImage image = film.develop();
  int c = 0;
  for (const char* channel : {"R", "G", "B"})
    EXPECT_EQ(image.channels.at(channel)[0], static_cast<float>(sum[c++] / kPasses)) << channel;
}

TEST(Film, PassesCountAsTheyShareTheirNoise) {
  // Passes that are off by one number everywhere, under a filter that sees many of their samples:
  // the variance of a pixel is that of the mean of these numbers. Every fourth makes up for the
  // three before: then there is no noise at all.
  const auto gaussian = make<Filter>("gaussian", {});
  constexpr int kPasses = 402;  // two of them are in no sample yet
  for (const bool isBalanced : {false, true}) {
    Film film = makeFilm(*gaussian, {8, 8}, {{0, 0}, {8, 8}}, true);
    Rng rng(9);
    double sum = 0, squares = 0;
    float balance = 0;
    for (int pass = 0; pass < kPasses; ++pass) {
      float noise = rng.uniform() - 0.5f;
      if (isBalanced && pass % 4 == 3)
        noise = -std::exchange(balance, 0.f);
      else
        balance += noise;
      sum += double{noise};
      squares += sqr(double{noise});
      FilmTile tile = film.makeTileOfPass(film.sampleBounds());
      const Bounds2i all = film.sampleBounds();
      for (int y = all.lo.y; y < all.hi.y; ++y)
        for (int x = all.lo.x; x < all.hi.x; ++x)
          tile.addSample(Vec2(x, y) + rng.uniform2(), Rgb(2 + noise));
      film.mergeIntoPass(tile);
      film.endPass();
    }
    const LayeredImage image = film.develop();
    const double expected = (squares / kPasses - sqr(sum / kPasses)) / kPasses;
    EXPECT_EQ(image.channels.at("samples")[27], kPasses / Film::kPassesPerSample);
    EXPECT_NEAR(image.channels.at("G")[27], 2 + sum / kPasses, isBalanced ? 0.02 : 0.05);
    // 100 samples tell a variance to 14 %; weights of the filter add a little.
    if (isBalanced)
      EXPECT_LT(image.channels.at("variance.G")[27], 0.15 * expected);
    else
      EXPECT_NEAR(image.channels.at("variance.G")[27] / expected, 1, 0.5);
  }
}

TEST(Film, FewSamplesHaveUnknownVariance) {
  const auto box = make<Filter>("box", {});
  Film film = makeFilm(*box, {2, 1}, {{0, 0}, {2, 1}}, true);
  FilmTile tile = film.makeTile({{0, 0}, {2, 1}});
  tile.addSample({0.5f, 0.5f}, Rgb(3));
  film.merge(tile);
  const LayeredImage image = film.develop();
  EXPECT_EQ(image.channels.at("R")[0], 3);
  EXPECT_EQ(image.channels.at("R")[1], 0);
  EXPECT_TRUE(std::isinf(image.channels.at("variance.R")[0]));
  EXPECT_TRUE(std::isinf(film.estimatedRelativeError()));
}

TEST(Film, NegativeLobesEndAtZero) {
  const auto mitchell = make<Filter>("mitchell", {});
  Film film = makeFilm(*mitchell, {5, 1}, {{0, 0}, {5, 1}});
  FilmTile tile = film.makeTile(film.sampleBounds());
  for (int x = 0; x < 5; ++x) tile.addSample(Vec2(x, 0) + Vec2(0.5f), Rgb(x == 2 ? 100.f : 0.f));
  tile.addSample({2.f, std::numeric_limits<float>::quiet_NaN()}, Rgb(1));  // reaches nothing
  film.merge(tile);
  const std::vector<float> row = film.develop().channels.at("R");
  EXPECT_GT(row[2], 80);
  EXPECT_EQ(row[4], 0);  // weight at distance 2 is 0
  for (float v : row) EXPECT_GE(v, 0);
}

TEST(ImageFilm, ResolutionCropAndName) {
  auto film = makeImage({integers("xresolution", {200}), integers("yresolution", {100}),
                         floats("cropwindow", {0.75f, 0.25f, 0, 0.333f})});
  EXPECT_EQ(film->resolution(), Vec2i(200, 100));
  EXPECT_EQ(film->settings().crop.lo, Vec2i(50, 0));
  EXPECT_EQ(film->settings().crop.hi, Vec2i(150, 34));
  EXPECT_EQ(film->settings().filename, "pbrt.exr");

  Film::FactoryContext context;
  context.quick = true;
  film =
      makeImage({integers("xresolution", {3}), floats("cropwindow", {1, 1, 0.5f, 0.5f})}, context);
  EXPECT_EQ(film->resolution(), Vec2i(1, 120));
  EXPECT_EQ(film->settings().crop.area(), 1);  // an empty window is one pixel
  EXPECT_EQ(film->settings().crop.lo, Vec2i(0, 60));

  context.resolution = Vec2i(7, 9);
  context.crop = std::array<float, 4>{0, 1, 0, 1};
  context.outputName = "other.png";
  film = makeImage({string("filename", "scene.exr")}, context);
  EXPECT_EQ(film->resolution(), Vec2i(7, 9));
  EXPECT_EQ(film->settings().filename, "other.png");
}

TEST(ImageFilm, RefusesWhatCannotBe) {
  for (int n : {0, -5, (1 << 20) + 1})
    EXPECT_THROW(makeImage({integers("xresolution", {n})}), SceneError) << n;
  EXPECT_NO_THROW(makeImage({integers("xresolution", {1}), integers("yresolution", {1})}));
  EXPECT_THROW(makeImage({string("filename", "image.bmp")}), SceneError);
  EXPECT_THROW(makeImage({floats("cropwindow", {0, 1.1f, 0, 1})}), SceneError);
  EXPECT_THROW(makeImage({string("precision", "double")}), SceneError);
  try {
    makeImage({integers("xresolution", {100000}), integers("yresolution", {100000})});
    FAIL() << "a film of 440 GB was made";
  } catch (const SceneError& e) {
    EXPECT_THAT(e.what(), HasSubstr("100000 x 100000 pixels needs 440.0 GB"));
  }
  // A crop window of the same image fits.
  EXPECT_NO_THROW(makeImage({integers("xresolution", {100000}), integers("yresolution", {100000}),
                             floats("cropwindow", {0.5f, 0.501f, 0, 0.001f})}));
}

}  // namespace
}  // namespace brume
