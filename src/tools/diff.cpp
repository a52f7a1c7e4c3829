// SPDX-License-Identifier: Apache-2.0
#include "tools/diff.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/io/image.h"
#include "core/srgb.h"
#include "tools/image_metrics.h"
#include "tools/json_report.h"

namespace brume {
namespace {

/// The share of the blocks that --max-block-error speaks of.
constexpr double kBlockShare = 0.95;
constexpr const char* kChannels[] = {"R", "G", "B"};

/// All figures of one comparison.
struct Figures {
  Vec2i size{0};
  ImageError error;  ///< of pixels, or of block means
  double flip = 0;
  std::optional<BlockComparison> blocks;
  std::optional<ZTest> z;
};

struct ImagePair {
  LayeredImage a, b;
  RgbImage rgbA, rgbB;
};

/// PNG, TGA and JPEG hold sRGB codes; errors are measured in linear light.
bool holdsSrgb(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const std::string_view encoded[] = {".png", ".tga", ".jpg", ".jpeg"};
  return std::find(std::begin(encoded), std::end(encoded), extension) != std::end(encoded);
}

RgbImage linearImage(const std::string& path, const LayeredImage& layers) {
  RgbImage image = toRgbImage(layers);
  if (holdsSrgb(path))
    for (Rgb& pixel : image.pixels)
      pixel = Rgb(decodeSrgb(pixel.r), decodeSrgb(pixel.g), decodeSrgb(pixel.b));
  return image;
}

ImagePair readPair(const DiffOptions& options) {
  ImagePair pair{readLayeredImage(options.image), readLayeredImage(options.reference), {}, {}};
  pair.rgbA = linearImage(options.image, pair.a);
  pair.rgbB = linearImage(options.reference, pair.b);
  if (pair.rgbA.width != pair.rgbB.width || pair.rgbA.height != pair.rgbB.height)
    throw SceneError(fmt::format("the images differ in size: '{}' has {} x {} pixels, '{}' {} x {}",
                                 options.image, pair.rgbA.width, pair.rgbA.height,
                                 options.reference, pair.rgbB.width, pair.rgbB.height));
  return pair;
}

Figures measure(const DiffOptions& options, const ImagePair& pair) {
  Figures figures;
  figures.size = {pair.rgbA.width, pair.rgbA.height};
  if (options.block > 1) {
    figures.blocks = compareBlocks(pair.rgbA, pair.rgbB, options.block);
    figures.error = compareImages(figures.blocks->a, figures.blocks->b);
  } else {
    figures.error = compareImages(pair.rgbA, pair.rgbB);
  }
  figures.flip = flip(pair.rgbA, pair.rgbB).mean;
  figures.z = zTest(pair.a, pair.b);
  if (options.zTest && !figures.z)
    throw SceneError("--z-test needs variance layers in both images; brume --variance writes them");
  if (options.maxBlockError && !figures.blocks)
    throw SceneError("--max-block-error needs --block with blocks of at least 2 pixels");
  return figures;
}

double meanRatioError(const ImageError& error) {
  double worst = 0;
  for (const double ratio : error.meanRatio) worst = std::max(worst, std::abs(ratio - 1));
  return worst;
}

/// The limits that were passed, in words. A figure that is not a number passes every limit.
std::vector<std::string> failures(const DiffOptions& options, const Figures& figures) {
  std::vector<std::string> failed;
  bool isLimited = false;
  const auto atMost = [&](const char* name, double value, const std::optional<double>& limit) {
    isLimited = isLimited || limit;
    if (limit && !(value <= *limit))
      failed.push_back(fmt::format("{} {:.4g} is above {:.4g}", name, value, *limit));
  };
  const auto atLeast = [&](const char* name, double value, const std::optional<double>& limit) {
    isLimited = isLimited || limit;
    if (limit && !(value >= *limit))
      failed.push_back(fmt::format("{} {:.4g} is below {:.4g}", name, value, *limit));
  };
  const ImageError& error = figures.error;
  atMost("MSE", error.mse, options.maxMse);
  atMost("relMSE", error.relMse, options.maxRelMse);
  atMost("MAE", error.mae, options.maxMae);
  atLeast("PSNR", error.psnr, options.minPsnr);
  atMost("FLIP", figures.flip, options.maxFlip);
  atMost("mean ratio error", meanRatioError(error), options.maxMeanRatioError);
  if (figures.blocks)
    atMost("block error", figures.blocks->quantile(kBlockShare), options.maxBlockError);
  if (figures.z) {
    atLeast("probability of the largest z", figures.z->sidakP, options.zTest);
    if (options.zTest && figures.z->fixedDiffer > 0)
      failed.push_back(
          fmt::format("{} pixel channels without variance differ", figures.z->fixedDiffer));
  }
  if (isLimited && error.nonFinitePixels > 0)
    failed.push_back(fmt::format("{} {} are not finite", error.nonFinitePixels,
                                 figures.blocks ? "blocks" : "pixels"));
  return failed;
}

std::string table(const DiffOptions& options, const Figures& figures,
                  const std::vector<std::string>& failed) {
  const ImageError& error = figures.error;
  std::string text;
  const auto row = [&text](const std::string& name, const std::string& value) {
    text += fmt::format("{:<12}{}\n", name, value);
  };
  row("image", options.image);
  row("reference", fmt::format("{}  ({} x {})", options.reference, figures.size.x, figures.size.y));
  if (figures.blocks) row("of means of", fmt::format("{0} x {0} pixels", options.block));
  row("MSE", fmt::format("{:.6g}", error.mse));
  row("relMSE", fmt::format("{:.6g}", error.relMse));
  row("relative", fmt::format("{:.6g} (the error that --error estimates)", error.relative));
  row("MAE", fmt::format("{:.6g}", error.mae));
  row("PSNR", fmt::format("{:.2f} dB (peak {:.4g})", error.psnr, error.peak));
  row("FLIP", fmt::format("{:.6f}", figures.flip));
  row("largest",
      fmt::format("{:.6g} at ({}, {})", error.maxAbs, error.maxAbsPixel.x, error.maxAbsPixel.y));
  for (std::size_t c = 0; c < 3; ++c)
    row(fmt::format("mean {}", kChannels[c]),
        fmt::format("{:.6g} / {:.6g} = {:.5f}", error.meanA[c], error.meanB[c],
                    error.meanRatio[c]));
  if (figures.blocks)
    row("blocks",
        fmt::format("half within {:.3g}, 95 % within {:.3g}, all within {:.3g} (relative)",
                    figures.blocks->quantile(0.5), figures.blocks->quantile(kBlockShare),
                    figures.blocks->quantile(1)));
  if (figures.z)
    row("z-test",
        fmt::format("largest |z| {:.3g} at ({}, {}), p {:.3g} over {} tests; mean z "
                    "{:.3g}, mean z^2 {:.3g}",
                    figures.z->maxAbsZ, figures.z->maxPixel.x, figures.z->maxPixel.y,
                    figures.z->sidakP, figures.z->tests, figures.z->meanZ, figures.z->meanZ2));
  if (error.nonFinitePixels > 0)
    row("not finite", fmt::format("{} {}, left out", error.nonFinitePixels,
                                  figures.blocks ? "blocks" : "pixels"));
  for (const std::string& failure : failed) row("FAILED", failure);
  return text;
}

std::string json(const DiffOptions& options, const Figures& figures,
                 const std::vector<std::string>& failed) {
  const ImageError& error = figures.error;
  FigureList list;
  list.words = {{"image", options.image}, {"reference", options.reference}};
  list.numbers = {{"width", figures.size.x}, {"height", figures.size.y},
                  {"block", options.block},  {"mse", error.mse},
                  {"relmse", error.relMse},  {"relative", error.relative},
                  {"mae", error.mae},        {"psnr", error.psnr},
                  {"peak", error.peak},      {"flip", figures.flip},
                  {"largest", error.maxAbs}, {"not finite", double(error.nonFinitePixels)}};
  const auto toVector = [](const std::array<double, 3>& v) {
    return std::vector<double>(v.begin(), v.end());
  };
  list.lists = {{"mean image", toVector(error.meanA)},
                {"mean reference", toVector(error.meanB)},
                {"mean ratio", toVector(error.meanRatio)}};
  if (figures.blocks) list.numbers["block error"] = figures.blocks->quantile(kBlockShare);
  if (figures.z) {
    list.numbers["z largest"] = figures.z->maxAbsZ;
    list.numbers["z p"] = figures.z->sidakP;
    list.numbers["z mean"] = figures.z->meanZ;
    list.numbers["z mean square"] = figures.z->meanZ2;
  }
  list.failures = failed;
  return figuresJson(list);
}

/// The significance of each pixel's difference after a z-test, else its relative error.
void writeHeatmap(const DiffOptions& options, const ImagePair& pair, const Figures& figures) {
  const RgbImage colours = options.zTest ? heatmap(significanceMap(figures.z->pValues))
                                         : heatmap(relativeErrorMap(pair.rgbA, pair.rgbB));
  writeImage(options.heatmap, colours);
}

}  // namespace

DiffOutcome compareImageFiles(const DiffOptions& options) {
  const ImagePair pair = readPair(options);
  const Figures figures = measure(options, pair);
  const std::vector<std::string> failed = failures(options, figures);
  if (!options.heatmap.empty()) writeHeatmap(options, pair, figures);
  return {options.json ? json(options, figures, failed) : table(options, figures, failed),
          failed.empty()};
}

}  // namespace brume
