// SPDX-License-Identifier: Apache-2.0
// How far one image is from another: error figures, block means, FLIP, and z-tests with per-pixel
// variances. Nothing here reads files or prints.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/io/image.h"
#include "core/math.h"

namespace brume {

/// One number per pixel, row-major from the top.
struct ScalarImage {
  int width = 0, height = 0;
  std::vector<float> values;

  ScalarImage() = default;
  ScalarImage(int w, int h)
      : width(w), height(h), values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  float& at(int x, int y) { return values[static_cast<std::size_t>(y) * width + x]; }
  float at(int x, int y) const { return values[static_cast<std::size_t>(y) * width + x]; }
};

/// Mean over all pixels and channels; pixels that are not finite are left out.
double meanOf(const RgbImage& image);

/// relMSE divides each squared difference by reference^2 + kRelMseEpsilon.
inline constexpr double kRelMseEpsilon = 0.01;

/// Error of an image A against a reference B of the same size. Means over pixels and channels, in
/// double; a pixel with a NaN or infinite channel in either image counts in nonFinitePixels and
/// nowhere else.
struct ImageError {
  double mse = 0;     ///< mean (a - b)^2
  double relMse = 0;  ///< mean (a - b)^2 / (b^2 + 0.01)
  /// Root of the mean of (a - b)^2 / (b^2 + kDarkShare meanB^2): does not change when both images
  /// are scaled. What --error estimates.
  double relative = 0;
  double mae = 0;        ///< mean |a - b|
  double psnr = 0;       ///< 10 log10(peak^2 / mse) [dB]; infinite for equal images
  double peak = 0;       ///< largest channel of B, the peak of psnr
  double maxAbs = 0;     ///< largest |a - b|
  Vec2i maxAbsPixel{0};  ///< where
  std::array<double, 3> meanA{}, meanB{};  ///< per channel
  std::array<double, 3> meanRatio{};       ///< meanA / meanB; 1 where both are 0
  std::uint64_t pixels = 0;                ///< compared
  std::uint64_t nonFinitePixels = 0;       ///< left out
};
/// Throws SceneError when the sizes differ, as all functions here do.
ImageError compareImages(const RgbImage& a, const RgbImage& b);

/// Means over blocks of block x block pixels (smaller at the right and bottom edge). A non-finite
/// pixel makes its block NaN.
RgbImage blockMeans(const RgbImage& image, int block);
/// The same of R, G and B and, where there are any, of their variances: that of a mean of
/// independent pixels is the mean variance over the number of pixels.
LayeredImage blockMeans(const LayeredImage& image, int block);

/// The means of two images over the same blocks.
struct BlockComparison {
  RgbImage a, b;  ///< one pixel per block
  /// Per block: largest over channels of |a - b| / max(|b|, 1e-3 mean of |b| over the image);
  /// infinite for a non-finite block. The floor keeps black blocks from dividing by nothing.
  ScalarImage relative;
  /// Share of the blocks whose relative difference is at most `tolerance`.
  double fractionWithin(double tolerance) const;
  /// The relative difference that the share `fraction` of the blocks does not exceed.
  double quantile(double fraction) const;
};
BlockComparison compareBlocks(const RgbImage& a, const RgbImage& b, int block);

/// Difference seen by a person who flips between two images on a screen, 0..1 per pixel.
struct FlipResult {
  ScalarImage map;
  double mean = 0;
};
/// LDR-FLIP of linear images that are clipped to [0, 1] and encoded for an sRGB screen. NaN counts
/// as 0. Source: Andersson et al. 2020, FLIP: A Difference Evaluator for Alternating Images. The
/// default is a 0.7 m distant screen of 3840 pixels on 0.7 m.
FlipResult flip(const RgbImage& a, const RgbImage& b, double pixelsPerDegree = 67.02064327658226);

/// Whether two images with per-pixel variances ("variance.R/G/B", variance of the pixel value) have
/// the same expectation. Pixels are taken to be independent (true of the box filter of width 1) and
/// normally distributed.
struct ZTest {
  std::uint64_t tests = 0;  ///< pixel channels with a variance above rounding in either image
  double maxAbsZ = 0;       ///< largest |a - b| / sqrt(va + vb)
  Vec2i maxPixel{0};        ///< where, from the corner of the data window
  int maxChannel = 0;
  double sidakP = 1;        ///< probability that `tests` unbiased channels give such a maximum
  double meanZ = 0;         ///< mean z: a bias over the whole image
  double meanZP = 1;        ///< its two-sided p-value, sqrt(tests) meanZ ~ N(0, 1)
  double meanZ2 = 0;        ///< mean z^2: 1 when the variances are right
  double ksDistance = 0;    ///< largest distance of the distribution of z from N(0, 1)
  double ksP = 1;           ///< its Kolmogorov-Smirnov p-value
  std::uint64_t fixed = 0;  ///< pixel channels without variance in both images
  std::uint64_t fixedDiffer = 0;  ///< ... that differ by more than 1e-4 of their size
  ScalarImage pValues;            ///< smallest two-sided p-value over the channels of each pixel
};
bool hasVariance(const LayeredImage& image);
/// None when either image lacks its variance layers.
std::optional<ZTest> zTest(const LayeredImage& a, const LayeredImage& b);

/// Per pixel the mean over channels of |a - b| / (|b| + 0.01); a non-finite pixel is infinite.
ScalarImage relativeErrorMap(const RgbImage& a, const RgbImage& b);
/// -log10(p) / 10 for each pixel, so that p = 1 is 0 and p = 1e-10 is 1.
ScalarImage significanceMap(const ScalarImage& pValues);
/// Colours from black through purple and orange to pale yellow for 0..1 (values outside take the
/// end colours, NaN is green), in linear RGB, ready for writeImage. Source of the colours: magma
/// (van der Walt and Smith 2015, CC0).
RgbImage heatmap(const ScalarImage& image);

}  // namespace brume
