// SPDX-License-Identifier: Apache-2.0
#include "core/mipmap.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/rng.h"

namespace brume {
namespace {

MipMapSettings wrapped(WrapMode wrap) { return {wrap, false, 8.f}; }

/// Fixed pseudo-random values in [0, 1), the same everywhere.
std::vector<float> noiseImage(int width, int height) {
  std::vector<float> values;
  std::uint32_t state = 12345;
  for (int i = 0; i < width * height; ++i) {
    state = state * 1664525u + 1013904223u;
    values.push_back(static_cast<float>(state >> 8) * 0x1p-24f);
  }
  return values;
}

float mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float v : values) sum += v;
  return static_cast<float>(sum / static_cast<double>(values.size()));
}

TEST(MipMap, ConstantImageStaysConstantUnderEveryFilter) {
  // 1e-6: the weights are normalised, so only rounding remains.
  for (const auto& [w, h] : {std::pair{1, 1}, {16, 16}, {5, 7}, {64, 3}}) {
    for (const WrapMode wrap : {WrapMode::Repeat, WrapMode::Clamp}) {
      const MipMap<Rgb> map(w, h,
                            std::vector<Rgb>(static_cast<std::size_t>(w * h), Rgb(.1f, .5f, 3.f)),
                            wrapped(wrap));
      for (const float size : {0.f, 1e-5f, .01f, .2f, 3.f, 1e20f})
        for (const Vec2& st : {Vec2(0.f), Vec2(.3f, .9f), Vec2(-7.2f, 1e9f)}) {
          const Rgb ewa = map.lookup(st, {size, .2f * size}, {-.1f * size, .4f * size});
          const Rgb trilinear = map.lookup(st, size);
          for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(ewa[c] / Rgb(.1f, .5f, 3.f)[c], 1, 1e-6f);
            EXPECT_NEAR(trilinear[c] / Rgb(.1f, .5f, 3.f)[c], 1, 1e-6f);
          }
        }
    }
  }
}

TEST(MipMap, PowersOfTwoAreKeptAndEveryLevelHasTheMean) {
  const std::vector<float> image = noiseImage(32, 8);
  const MipMap<float> map(32, 8, image, wrapped(WrapMode::Black));
  ASSERT_EQ(map.levels(), 6);
  EXPECT_EQ(map.texel(0, 3, 2), image[2 * 32 + 3]);
  for (int level = 0; level < map.levels(); ++level) {
    const int w = std::max(1, 32 >> level), h = std::max(1, 8 >> level);
    double sum = 0;
    for (int t = 0; t < h; ++t)
      for (int s = 0; s < w; ++s) sum += map.texel(level, s, t);
    // Also where one side is a single texel already, and with black around.
    EXPECT_NEAR(sum / (w * h), mean(image), 1e-6);
  }
}

TEST(MipMap, ResamplingKeepsMeanAndLinearRamps) {
  // A periodic image of 12 x 6 texels becomes 16 x 8; Lanczos keeps its mean to its ripple (0.5 %).
  const MipMap<float> map(12, 6, noiseImage(12, 6), wrapped(WrapMode::Repeat));
  ASSERT_EQ(map.width(), 16);
  ASSERT_EQ(map.height(), 8);
  EXPECT_NEAR(map.texel(map.levels() - 1, 0, 0), mean(noiseImage(12, 6)), 5e-3f);

  // The value at a texel centre is its s coordinate; away from the border it must stay so, to the
  // window's error on slopes (2 % of a texel).
  std::vector<float> ramp;
  for (int i = 0; i < 24 * 3; ++i) ramp.push_back((static_cast<float>(i % 24) + .5f) / 24.f);
  const MipMap<float> clamped(24, 3, ramp, wrapped(WrapMode::Clamp));
  for (int s = 3; s < 29; ++s)
    EXPECT_NEAR(clamped.texel(0, s, 1), (static_cast<float>(s) + .5f) / 32.f, .02f / 24.f * 3) << s;
}

TEST(MipMap, LinearRampIsReproducedByEveryFilter) {
  constexpr int kSize = 64;
  std::vector<float> ramp;
  for (int i = 0; i < kSize * kSize; ++i)
    ramp.push_back((static_cast<float>(i % kSize) + .5f) / kSize);
  const MipMap<float> map(kSize, kSize, ramp, wrapped(WrapMode::Clamp));
  // Bilinear interpolation is exact; the symmetric filters are to the asymmetry of the texels under
  // them (a tenth of a texel of their level).
  EXPECT_NEAR(map.lookup({.413f, .5f}), .413f, 1e-6f);
  EXPECT_NEAR(map.lookup({.413f, .5f}, Vec2(0.f), Vec2(0.f)), .413f, 1e-6f);
  for (const float size : {.01f, .03f, .06f}) {
    EXPECT_NEAR(map.lookup({.413f, .5f}, size), .413f, 1e-5f);
    EXPECT_NEAR(map.lookup({.413f, .5f}, {size, 0}, {0, size}), .413f, .2f * size);
    EXPECT_NEAR(map.lookup({.413f, .5f}, {2 * size, size}, {-.3f * size, .5f * size}), .413f,
                .2f * size);
  }
}

TEST(MipMap, WrapModes) {
  const std::vector<float> image{1, 2, 3, 4};
  const MipMap<float> repeat(2, 2, image, wrapped(WrapMode::Repeat));
  const MipMap<float> black(2, 2, image, wrapped(WrapMode::Black));
  const MipMap<float> clamp(2, 2, image, wrapped(WrapMode::Clamp));
  EXPECT_EQ(repeat.texel(0, -1, 0), 2);
  EXPECT_EQ(repeat.texel(0, 4, -3), 3);
  EXPECT_EQ(black.texel(0, -1, 0), 0);
  EXPECT_EQ(clamp.texel(0, 9, -9), 2);
  EXPECT_EQ(repeat.lookup({1.25f, -.25f}), 3);
  EXPECT_EQ(black.lookup({1.3f, .25f}), 0);
  EXPECT_EQ(clamp.lookup({1.3f, .25f}), 2);
  // Half of the bilinear filter lies outside.
  EXPECT_FLOAT_EQ(black.lookup({0.f, .25f}), .5f);
  EXPECT_FLOAT_EQ(repeat.lookup({0.f, .25f}), 1.5f);
}

TEST(MipMap, IsotropicFootprintsAgreeWithTrilinear) {
  const MipMap<float> map(64, 64, noiseImage(64, 64), wrapped(WrapMode::Repeat));
  const MipMap<float> trilinear(64, 64, noiseImage(64, 64), {WrapMode::Repeat, true, 8.f});
  double difference = 0, deviation = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec2 st(std::fmod(.137f * static_cast<float>(i), 1.f),
                  std::fmod(.711f * static_cast<float>(i), 1.f));
    const float a = map.lookup(st, {.08f, 0}, {0, .08f});
    const float b = trilinear.lookup(st, {.08f, 0}, {0, .08f});
    EXPECT_EQ(b, map.lookup(st, .16f));
    difference += sqr(a - b);
    deviation += sqr(a - .5f);
  }
  // Two low-pass filters of the same width differ by less than what either lets through.
  EXPECT_LT(difference, deviation);
  EXPECT_GT(deviation, 0);
}

/// Direct sum over all texels of level 0 of a white-noise image: EWA on the pyramid blurs a little
/// more, so the two agree to a part of the contrast.
TEST(MipMap, EwaFollowsTheOrientationOfItsFootprint) {
  // Vertical stripes of one texel: a footprint along the stripes keeps them, across averages them.
  std::vector<float> stripes;
  for (int i = 0; i < 64 * 64; ++i) stripes.push_back(i % 8 < 4 ? 1.f : 0.f);
  const MipMap<float> map(64, 64, stripes, wrapped(WrapMode::Repeat));
  const float along = map.lookup({2.f / 64, .5f}, {0, .12f}, {1.f / 64, 0});
  const float across = map.lookup({2.f / 64, .5f}, {.12f, 0}, {0, 1.f / 64});
  EXPECT_GT(along, .9f);
  EXPECT_NEAR(across, .5f, .1f);
  // Axes in either order, and turned by the symmetry s <-> t.
  EXPECT_EQ(map.lookup({.3f, .5f}, {.1f, .02f}, {.01f, .05f}),
            map.lookup({.3f, .5f}, {.01f, .05f}, {.1f, .02f}));
}

TEST(MipMap, EwaIsTheGaussianSumOverTheEllipse) {
  // A single bright texel shows the filter itself. Level 0 alone is used when the shorter axis is
  // at most one texel.
  constexpr int kSize = 32;
  std::vector<float> dot1(kSize * kSize, 0.f);
  dot1[16 * kSize + 16] = 1;
  const MipMap<float> map(kSize, kSize, dot1, wrapped(WrapMode::Clamp));
  const Vec2 d0(3.f / kSize, 1.f / kSize), d1(-.2f / kSize, .6f / kSize);
  // The ellipse matrix from its definition: inverse of J J^T + I in texels.
  const double a = 9 + .04 + 1, b = 3 - .12, c = 1 + .36 + 1, det = a * c - b * b;
  const auto weight = [&](double x, double y) {
    const double r2 = (c * x * x - 2 * b * x * y + a * y * y) / det;
    if (r2 >= 1) return 0.;
    const double step = std::floor(r2 * 128) / 127;  // the tabulated Gaussian
    return std::exp(-2 * step) - std::exp(-2.);
  };
  for (const Vec2& offset : {Vec2(0.f), Vec2(.3f, -.4f), Vec2(2.2f, .9f), Vec2(-1.5f, -.5f)}) {
    double sum = 0;
    for (int y = -8; y <= 8; ++y)
      for (int x = -8; x <= 8; ++x) sum += weight(double(x) - offset.x, double(y) - offset.y);
    const Vec2 st = (Vec2(16.5f) + offset) / static_cast<float>(kSize);
    EXPECT_NEAR(map.lookup(st, d0, d1), weight(-offset.x, -offset.y) / sum, 2e-3);
  }
}

TEST(MipMap, StrangeFootprintsAreFinite) {
  const MipMap<float> map(16, 16, noiseImage(16, 16), {WrapMode::Clamp, false, 1024.f});
  const float inf = kInfinity, nan = std::nanf("");
  for (const Vec2& st : {Vec2(.5f), Vec2(inf, -inf), Vec2(nan), Vec2(1e30f)})
    for (const Vec2& d0 :
         {Vec2(0.f), Vec2(1e-30f), Vec2(1e30f), Vec2(inf, 0.f), Vec2(nan), Vec2(.7f)})
      for (const Vec2& d1 :
           {Vec2(0.f), Vec2(-1e-30f, 1e-25f), Vec2(.7f), Vec2(1e-4f, 0.f), Vec2(nan)}) {
        const float value = map.lookup(st, d0, d1);
        EXPECT_GE(value, 0);
        EXPECT_LE(value, 1);
      }
}

TEST(MipMap, ThinFootprintsAreWidenedToTheMaximalAnisotropy) {
  const MipMap<float> map(64, 64, noiseImage(64, 64), wrapped(WrapMode::Repeat));
  EXPECT_FLOAT_EQ(map.lookup({.3f, .3f}, {.4f, 0}, {0, .001f}),
                  map.lookup({.3f, .3f}, {.4f, 0}, {0, .05f}));
}

}  // namespace
}  // namespace brume
