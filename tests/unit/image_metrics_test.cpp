// SPDX-License-Identifier: Apache-2.0
#include "tools/image_metrics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace brume {
namespace {

RgbImage filled(int width, int height, const Rgb& value) {
  RgbImage image(width, height);
  for (Rgb& pixel : image.pixels) pixel = value;
  return image;
}

TEST(ImageError, ClosedForms) {
  RgbImage a = filled(2, 2, Rgb(1.f)), b = filled(2, 2, Rgb(.5f, 1, 2));
  const ImageError error = compareImages(a, b);
  EXPECT_DOUBLE_EQ(error.mse, (.25 + 0 + 1) / 3);
  EXPECT_DOUBLE_EQ(error.relMse, (.25 / .26 + 1 / 4.01) / 3);
  const double dark = 0.01 * sqr(3.5 / 3);
  EXPECT_NEAR(error.relative, std::sqrt((.25 / (.25 + dark) + 1 / (4 + dark)) / 3), 1e-12);
  EXPECT_DOUBLE_EQ(error.mae, 1.5 / 3);
  EXPECT_DOUBLE_EQ(error.psnr, 10 * std::log10(4 / error.mse));
  EXPECT_EQ(error.maxAbs, 1);
  EXPECT_EQ(error.meanRatio, (std::array<double, 3>{2, 1, .5}));
  EXPECT_EQ(error.pixels, 4u);

  const ImageError same = compareImages(b, b);
  EXPECT_EQ(same.mse, 0);
  EXPECT_EQ(same.psnr, kInfinity);

  a.at(1, 0) = Rgb(std::nanf(""));
  b.at(0, 1) = Rgb(kInfinity);
  const ImageError part = compareImages(a, b);
  EXPECT_EQ(part.nonFinitePixels, 2u);
  EXPECT_DOUBLE_EQ(part.mse, error.mse);
  EXPECT_THROW(compareImages(a, filled(2, 3, Rgb())), SceneError);
}

TEST(ImageError, TheRelativeErrorIsThatOfTheScaledImages) {
  RgbImage a = filled(2, 1, Rgb(1.f)), b = filled(2, 1, Rgb(1.25f));
  a.at(0, 0) = Rgb(0.f);
  const double error = compareImages(a, b).relative;
  for (RgbImage* image : {&a, &b})
    for (Rgb& pixel : image->pixels) pixel *= 0x1p-40f;
  EXPECT_NEAR(compareImages(a, b).relative, error, 1e-9 * error);
  EXPECT_EQ(compareImages(filled(2, 1, Rgb(0.f)), filled(2, 1, Rgb(0.f))).relative, 0);
}

TEST(ImageError, FindsTheWorstPixel) {
  const RgbImage b = filled(3, 2, Rgb(1.f));
  RgbImage a = b;
  a.at(2, 1).g = -4;
  EXPECT_EQ(compareImages(a, b).maxAbsPixel, Vec2i(2, 1));
}

TEST(Blocks, MeansAndPartialBlocks) {
  RgbImage image(3, 3);
  for (int i = 0; i < 9; ++i)
    image.pixels[static_cast<std::size_t>(i)] = Rgb(static_cast<float>(i));
  const RgbImage means = blockMeans(image, 2);
  ASSERT_EQ(means.width, 2);
  EXPECT_EQ(means.at(0, 0), Rgb(2.f));   // 0 1 3 4
  EXPECT_EQ(means.at(1, 0), Rgb(3.5f));  // 2 5
  EXPECT_EQ(means.at(1, 1), Rgb(8.f));
  EXPECT_EQ(blockMeans(image, 1).pixels, image.pixels);
  EXPECT_EQ(blockMeans(image, 1 << 30).at(0, 0), Rgb(4.f));
  EXPECT_THROW(blockMeans(image, 0), SceneError);
}

TEST(Blocks, FractionAndQuantile) {
  const RgbImage b = filled(4, 1, Rgb(1.f));
  RgbImage a = b;
  a.pixels = {Rgb(1.f), Rgb(1.f, 1.02f, 1.f), Rgb(.9f), Rgb(kInfinity)};
  const BlockComparison blocks = compareBlocks(a, b, 1);
  EXPECT_EQ(blocks.fractionWithin(0), .25);
  EXPECT_EQ(blocks.fractionWithin(.03), .5);
  EXPECT_EQ(blocks.fractionWithin(.11), .75);
  EXPECT_NEAR(blocks.quantile(.5), .02, 1e-6);
  EXPECT_NEAR(blocks.quantile(.75), .1, 1e-6);
  EXPECT_EQ(blocks.quantile(1), kInfinity);
  // A black block: the floor is a thousandth of the mean.
  RgbImage dark = b;
  dark.pixels[0] = Rgb(0.f);
  RgbImage nearly = dark;
  nearly.pixels[0] = Rgb(1e-6f);
  EXPECT_NEAR(compareBlocks(nearly, dark, 1).relative.at(0, 0), 1e-3 / .75, 1e-5);
}

TEST(Flip, EqualImagesAreZeroAndExtremesAreOne) {
  const RgbImage black = filled(8, 8, Rgb(0.f)), white = filled(8, 8, Rgb(1.f));
  EXPECT_EQ(flip(white, white).mean, 0);
  // Lightness differs by 100, chroma by nothing; green against blue, the largest difference, is
  // 203.3 (from their CIELAB values 87.73 -86.18 83.18 and 32.30 79.19 -107.86). Exponent 0.7,
  // then the knee.
  const double largest = std::pow(203.33, .7), error = std::pow(100., .7);
  EXPECT_NEAR(flip(black, white).mean, .95 + .05 * (error - .4 * largest) / (.6 * largest), 1e-3);
  EXPECT_NEAR(flip(filled(4, 4, Rgb(0, 1, 0)), filled(4, 4, Rgb(0, 0, 1))).mean, 1, 1e-4);
  // Clipping and NaN.
  EXPECT_NEAR(flip(filled(4, 4, Rgb(7.f)), filled(4, 4, Rgb(1.f))).mean, 0, 1e-6);
  EXPECT_NEAR(flip(filled(4, 4, Rgb(std::nanf(""))), filled(4, 4, Rgb(-1.f))).mean, 0, 1e-6);
  EXPECT_THROW(flip(black, white, 0), SceneError);
}

/// The mean over this pair was computed by a program of its own, in doubles and with full
/// two-dimensional kernels: 0.12222372. Floats and separable kernels leave 2e-6.
TEST(Flip, EqualsAnIndependentComputation) {
  RgbImage a(40, 28), b(40, 28);
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      const double wave = std::sin(x * .7 + y * .2), ramp = y / 28. + .1 * std::sin(x);
      const double first[3] = {.5 + .45 * wave, (x / 5 + y / 4) % 2 ? .2 : .8,
                               std::clamp(ramp, 0., 1.)};
      const double factor = .8 + .4 * ((x * 7 + y * 13) % 11) / 11;
      const double patch = x > 10 && x < 20 && y > 8 && y < 15 ? .3 : 0;
      for (int c = 0; c < 3; ++c) {
        a.at(x, y)[c] = static_cast<float>(first[c]);
        b.at(x, y)[c] = static_cast<float>(std::clamp(first[c] * factor + patch, 0., 1.));
      }
    }
  EXPECT_NEAR(flip(a, b, 67).mean, .12222372, 1e-5);
}

TEST(Flip, IsSymmetricAndLocal) {
  RgbImage a = filled(64, 64, Rgb(.2f)), b = a;
  b.at(20, 30) = Rgb(.9f, .1f, .1f);
  const FlipResult ab = flip(a, b), ba = flip(b, a);
  for (std::size_t i = 0; i < ab.map.values.size(); ++i)
    EXPECT_EQ(ab.map.values[i], ba.map.values[i]);
  EXPECT_GT(ab.map.at(20, 30), .2f);
  EXPECT_GT(ab.map.at(20, 30), ab.map.at(26, 30));
  // The filters reach 10 pixels at 67 pixels per degree.
  EXPECT_NEAR(ab.map.at(50, 50), 0, 1e-4f);
  // A row transposed gives the transposed map.
  RgbImage bT = a;
  bT.at(30, 20) = b.at(20, 30);
  EXPECT_NEAR(flip(a, bT).map.at(33, 25), ab.map.at(25, 33), 1e-5f);
}

TEST(Flip, AnEdgeCountsMoreThanItsColour) {
  // The same colour error everywhere, but one image also has an edge that the other lacks: errors
  // near it grow.
  RgbImage a = filled(64, 16, Rgb(.25f)), b = filled(64, 16, Rgb(.25f));
  for (int y = 0; y < 16; ++y)
    for (int x = 32; x < 64; ++x) b.at(x, y) = Rgb(.35f);
  const FlipResult result = flip(a, b);
  EXPECT_GT(result.map.at(33, 8), 1.3f * result.map.at(60, 8));
  EXPECT_GT(result.map.at(60, 8), 0.f);
}

LayeredImage withVariance(const std::vector<float>& values, float variance, int width) {
  LayeredImage image;
  image.displaySize = {width, static_cast<int>(values.size()) / width};
  image.dataWindow = {{0, 0}, image.displaySize};
  for (const char* c : {"R", "G", "B"}) {
    image.channels[c] = values;
    image.channels[std::string("variance.") + c] = std::vector<float>(values.size(), variance);
  }
  return image;
}

TEST(ZTest, ClosedForms) {
  const LayeredImage a = withVariance({1, 1, 1, 1}, .5f, 2);
  LayeredImage b = a;
  b.channels["G"][2] = 3;
  const ZTest z = *zTest(a, b);
  EXPECT_EQ(z.tests, 12u);
  EXPECT_DOUBLE_EQ(z.maxAbsZ, 2);
  EXPECT_EQ(z.maxPixel, Vec2i(0, 1));
  EXPECT_EQ(z.maxChannel, 1);
  const double p = .04550026389635842;  // P(|N| > 2)
  EXPECT_NEAR(z.sidakP, 1 - std::pow(1 - p, 12), 1e-12);
  EXPECT_NEAR(z.meanZ, -2. / 12, 1e-12);
  EXPECT_NEAR(z.meanZ2, 4. / 12, 1e-12);
  EXPECT_NEAR(z.pValues.at(0, 1), p, 1e-6);
  EXPECT_EQ(z.pValues.at(0, 0), 1);
  EXPECT_NEAR(z.ksDistance, .5, 1e-6);  // eleven of twelve values at 0
}

TEST(ZTest, NeedsVariances) {
  LayeredImage a = withVariance({1}, 1, 1), b = a;
  EXPECT_TRUE(hasVariance(a));
  b.channels.erase("variance.B");
  EXPECT_FALSE(zTest(a, b).has_value());
  EXPECT_THROW(zTest(a, withVariance({1, 2}, 1, 1)), SceneError);
}

TEST(ZTest, PixelsWithoutVarianceMustAgree) {
  const LayeredImage a = withVariance({1, 2}, 0, 2);
  LayeredImage b = a;
  EXPECT_EQ(zTest(a, b)->fixed, 6u);
  EXPECT_EQ(zTest(a, b)->fixedDiffer, 0u);
  b.channels["R"][1] = 2.01f;
  EXPECT_EQ(zTest(a, b)->fixedDiffer, 1u);
  EXPECT_EQ(zTest(a, b)->sidakP, 1);
}

/// Sums of twelve uniforms minus six: normal to the eye of these tests.
std::vector<float> normals(int count, std::uint32_t state) {
  std::vector<float> values;
  for (int i = 0; i < count; ++i) {
    float sum = -6;
    for (int k = 0; k < 12; ++k) {
      state = state * 1664525u + 1013904223u;
      sum += static_cast<float>(state >> 8) * 0x1p-24f;
    }
    values.push_back(sum);
  }
  return values;
}

TEST(ZTest, AcceptsNoiseAndFindsBias) {
  constexpr int kSize = 64;
  LayeredImage a = withVariance(normals(kSize * kSize, 1), 1, kSize);
  LayeredImage b = withVariance(normals(kSize * kSize, 2), 1, kSize);
  for (const char* c : {"G", "B"}) {  // independent channels
    a.channels[c] = normals(kSize * kSize, 3u + static_cast<unsigned>(c[0]));
    b.channels[c] = normals(kSize * kSize, 1003u + static_cast<unsigned>(c[0]));
  }
  const ZTest fair = *zTest(a, b);
  EXPECT_GT(fair.sidakP, .01);
  EXPECT_GT(fair.meanZP, .01);
  EXPECT_GT(fair.ksP, .001);
  EXPECT_NEAR(fair.meanZ2, 1, .05);  // standard deviation sqrt(2 / 12288) = 0.013
  // A bias of a tenth of the noise per pixel shows in the mean of 12288 channels.
  for (const char* c : {"R", "G", "B"})
    for (float& v : a.channels[c]) v += .1f * std::sqrt(2.f);
  EXPECT_LT(zTest(a, b)->meanZP, 1e-6);
  // One wrong pixel shows in the maximum.
  b.channels["B"][77] += 12;
  EXPECT_LT(zTest(a, b)->sidakP, 1e-6);
}

TEST(Heatmap, ColoursAreOrderedAndClipped) {
  ScalarImage values(6, 1);
  values.values = {0, .5f, 1, -3, kInfinity, std::nanf("")};
  const RgbImage map = heatmap(values);
  EXPECT_LT(map.at(0, 0).luminance(), map.at(1, 0).luminance());
  EXPECT_LT(map.at(1, 0).luminance(), map.at(2, 0).luminance());
  EXPECT_EQ(map.at(3, 0), map.at(0, 0));
  EXPECT_EQ(map.at(4, 0), map.at(2, 0));
  EXPECT_EQ(map.at(5, 0), Rgb(0, 1, 0));
}

TEST(Maps, RelativeErrorAndSignificance) {
  const RgbImage b = filled(1, 1, Rgb(.99f)), a = filled(1, 1, Rgb(1.49f));
  EXPECT_NEAR(relativeErrorMap(a, b).at(0, 0), .5f, 1e-6f);
  ScalarImage p(3, 1);
  p.values = {1, 1e-5f, 0};
  const ScalarImage map = significanceMap(p);
  EXPECT_EQ(map.at(0, 0), 0);
  EXPECT_NEAR(map.at(1, 0), .5f, 1e-6f);
  EXPECT_EQ(map.at(2, 0), 1);
}

}  // namespace
}  // namespace brume
