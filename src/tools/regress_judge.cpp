// SPDX-License-Identifier: Apache-2.0
#include "tools/regress_judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace brume {
namespace {

constexpr const char* kVariances[] = {"variance.R", "variance.G", "variance.B"};
/// Pixels, blocks, the whole image.
constexpr int kLevels = 3;

/// `image` with variances no smaller than the reference's per sample say.
LayeredImage withFlooredVariance(LayeredImage image, const LayeredImage& reference) {
  if (!image.has("samples") || !reference.has("samples")) return image;
  const auto &n = image.channels.at("samples"), &nReference = reference.channels.at("samples");
  for (const char* name : kVariances) {
    std::vector<float>& variance = image.channels.at(name);
    const std::vector<float>& known = reference.channels.at(name);
    for (std::size_t i = 0; i < variance.size(); ++i)
      if (n[i] > 0) variance[i] = std::max(variance[i], known[i] * nReference[i] / n[i]);
  }
  return image;
}

bool hasFiniteVariance(const LayeredImage& image) {
  return std::all_of(std::begin(kVariances), std::end(kVariances), [&](const char* name) {
    const std::vector<float>& v = image.channels.at(name);
    return std::all_of(v.begin(), v.end(), [](float x) { return std::isfinite(x); });
  });
}

void judgeByZ(const LayeredImage& image, const LayeredImage& reference, const RegressRules& rules,
              RegressVerdict& verdict) {
  if (!hasVariance(image) || !hasVariance(reference))
    throw SceneError("a z-test needs variance layers in image and reference");
  if (!hasFiniteVariance(image) || !hasFiniteVariance(reference)) {
    verdict.failures.push_back("a z-test needs at least 2 samples in every pixel");
    return;
  }
  const int whole = std::max(image.dataWindow.width(), image.dataWindow.height());
  const double level = *rules.zTest / kLevels;
  const auto test = [&](const char* what, int block) {
    const auto z = block == 1 ? zTest(withFlooredVariance(image, reference), reference)
                              : zTest(blockMeans(image, block), blockMeans(reference, block));
    verdict.figures +=
        fmt::format("{}{} p {:.2g}", verdict.figures.empty() ? "" : ", ", what, z->sidakP);
    if (z->sidakP < level)
      verdict.failures.push_back(
          fmt::format("{}: p {:.3g} is below {:.3g} (largest |z| {:.2f} at ({}, {}))", what,
                      z->sidakP, level, z->maxAbsZ, z->maxPixel.x * block, z->maxPixel.y * block));
    if (z->fixedDiffer > 0)
      verdict.failures.push_back(
          fmt::format("{}: {} values without variance differ", what, z->fixedDiffer));
    if (block == 1)
      verdict.pValues = z->pValues;
    else if (block == rules.block)
      verdict.blockPValues = z->pValues;
  };
  test("pixels", 1);
  if (rules.block > 1) {
    test("blocks", rules.block);
    test("image", whole);
  }
}

}  // namespace

RegressVerdict judge(const LayeredImage& image, const LayeredImage& reference,
                     const RegressRules& rules) {
  const RgbImage a = toRgbImage(image), b = toRgbImage(reference);
  const ImageError error = compareImages(a, b);
  RegressVerdict verdict;
  if (rules.zTest) judgeByZ(image, reference, rules, verdict);
  const auto atMost = [&](const char* name, double value, const std::optional<double>& limit) {
    verdict.figures += fmt::format("{}{} {:.2g}", verdict.figures.empty() ? "" : ", ", name, value);
    if (limit && !(value <= *limit))
      verdict.failures.push_back(fmt::format("{} {:.4g} is above {:.4g}", name, value, *limit));
  };
  double ratioError = 0;
  for (const double ratio : error.meanRatio) ratioError = std::max(ratioError, std::abs(ratio - 1));
  atMost("relMSE", error.relMse, rules.maxRelMse);
  atMost("FLIP", flip(a, b).mean, rules.maxFlip);
  atMost("mean off by", ratioError, rules.maxMeanRatioError);
  if (error.nonFinitePixels > 0)
    verdict.failures.push_back(fmt::format("{} pixels are not finite", error.nonFinitePixels));
  return verdict;
}

}  // namespace brume
