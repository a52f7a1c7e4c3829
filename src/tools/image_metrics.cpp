// SPDX-License-Identifier: Apache-2.0
#include "tools/image_metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/film.h"

namespace brume {
namespace {

void requireSameSize(int wa, int ha, int wb, int hb) {
  if (wa != wb || ha != hb)
    throw SceneError(
        fmt::format("the images differ in size: {} x {} and {} x {} pixels", wa, ha, wb, hb));
}
void requireSameSize(const RgbImage& a, const RgbImage& b) {
  requireSameSize(a.width, a.height, b.width, b.height);
}

}  // namespace

double meanOf(const RgbImage& image) {
  double sum = 0;
  std::size_t count = 0;
  for (const Rgb& pixel : image.pixels) {
    if (!pixel.isFinite()) continue;
    for (int c = 0; c < 3; ++c) sum += pixel[c];
    count += 3;
  }
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

ImageError compareImages(const RgbImage& a, const RgbImage& b) {
  requireSameSize(a, b);
  ImageError error;
  double squares = 0, relative = 0, scaled = 0, absolute = 0;
  const double dark = std::max(kDarkShare * sqr(meanOf(b)), std::numeric_limits<double>::min());
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const Rgb &pa = a.pixels[i], &pb = b.pixels[i];
    if (!pa.isFinite() || !pb.isFinite()) {
      ++error.nonFinitePixels;
      continue;
    }
    ++error.pixels;
    for (int c = 0; c < 3; ++c) {
      const double va = pa[c], vb = pb[c], d = va - vb;
      squares += d * d;
      relative += d * d / (vb * vb + kRelMseEpsilon);
      scaled += d * d / (vb * vb + dark);
      absolute += std::abs(d);
      error.meanA[static_cast<std::size_t>(c)] += va;
      error.meanB[static_cast<std::size_t>(c)] += vb;
      error.peak = std::max(error.peak, vb);
      if (std::abs(d) > error.maxAbs) {
        error.maxAbs = std::abs(d);
        const auto width = static_cast<std::size_t>(a.width);
        error.maxAbsPixel = {static_cast<int>(i % width), static_cast<int>(i / width)};
      }
    }
  }
  const double pixels = std::max<double>(1, static_cast<double>(error.pixels)), values = 3 * pixels;
  error.mse = squares / values;
  error.relMse = relative / values;
  error.relative = std::sqrt(scaled / values);
  error.mae = absolute / values;
  error.psnr = error.mse > 0 ? 10 * std::log10(error.peak * error.peak / error.mse)
                             : std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < 3; ++c) {
    error.meanA[c] /= pixels;
    error.meanB[c] /= pixels;
    error.meanRatio[c] = error.meanA[c] == error.meanB[c] ? 1 : error.meanA[c] / error.meanB[c];
  }
  return error;
}

RgbImage blockMeans(const RgbImage& image, int block) {
  if (block < 1) throw SceneError(fmt::format("the block size must be at least 1, not {}", block));
  // No block is larger than the image, so that sums of its corners cannot overflow.
  block = std::min(block, std::max({1, image.width, image.height}));
  RgbImage means((image.width + block - 1) / block, (image.height + block - 1) / block);
  for (int by = 0; by < means.height; ++by)
    for (int bx = 0; bx < means.width; ++bx) {
      const int x1 = std::min((bx + 1) * block, image.width),
                y1 = std::min((by + 1) * block, image.height);
      double sum[3] = {0, 0, 0};
      for (int y = by * block; y < y1; ++y)
        for (int x = bx * block; x < x1; ++x)
          for (int c = 0; c < 3; ++c) sum[c] += image.at(x, y)[c];
      const double count = double(x1 - bx * block) * (y1 - by * block);
      Rgb& mean = means.at(bx, by);
      for (int c = 0; c < 3; ++c)
        mean[c] = std::isfinite(sum[c]) ? static_cast<float>(sum[c] / count)
                                        : std::numeric_limits<float>::quiet_NaN();
    }
  return means;
}

LayeredImage blockMeans(const LayeredImage& image, int block) {
  const Vec2i size{image.dataWindow.width(), image.dataWindow.height()};
  LayeredImage means;
  const auto add = [&](const std::string& prefix, bool isVariance) {
    RgbImage layer(size.x, size.y);
    for (int c = 0; c < 3; ++c) {
      const std::vector<float>& from = image.channels.at(prefix + "RGB"[c]);
      for (std::size_t i = 0; i < from.size(); ++i) layer.pixels[i][c] = from[i];
    }
    const RgbImage mean = blockMeans(layer, block);
    means.displaySize = {mean.width, mean.height};
    means.dataWindow = {Vec2i{0}, means.displaySize};
    for (int c = 0; c < 3; ++c) {
      std::vector<float>& to = means.channels[prefix + "RGB"[c]];
      for (int y = 0; y < mean.height; ++y)
        for (int x = 0; x < mean.width; ++x) {
          const float pixels = static_cast<float>((std::min((x + 1) * block, size.x) - x * block) *
                                                  (std::min((y + 1) * block, size.y) - y * block));
          to.push_back(mean.at(x, y)[c] / (isVariance ? pixels : 1.f));
        }
    }
  };
  block = std::min(block, std::max({1, size.x, size.y}));
  add("", false);
  if (image.has("variance.R")) add("variance.", true);
  return means;
}

BlockComparison compareBlocks(const RgbImage& a, const RgbImage& b, int block) {
  constexpr double kFloor = 1e-3;
  requireSameSize(a, b);
  BlockComparison result{blockMeans(a, block), blockMeans(b, block), {}};
  double sum = 0, count = 0;
  for (const Rgb& p : result.b.pixels)
    if (p.isFinite()) {
      sum += std::abs(p.r) + std::abs(p.g) + std::abs(p.b);
      count += 3;
    }
  const double floor = count > 0 ? kFloor * sum / count : 0;
  result.relative = ScalarImage(result.a.width, result.a.height);
  for (std::size_t i = 0; i < result.a.pixels.size(); ++i) {
    double worst = 0;
    for (int c = 0; c < 3; ++c) {
      const double va = result.a.pixels[i][c], vb = result.b.pixels[i][c];
      const double d = va == vb ? 0 : std::abs(va - vb) / std::max(std::abs(vb), floor);
      worst = d <= worst ? worst : std::isnan(d) ? kInfinity : d;
    }
    result.relative.values[i] = static_cast<float>(worst);
  }
  return result;
}

double BlockComparison::fractionWithin(double tolerance) const {
  if (relative.values.empty()) return 1;
  const auto within = std::count_if(relative.values.begin(), relative.values.end(),
                                    [&](float v) { return v <= tolerance; });
  return static_cast<double>(within) / static_cast<double>(relative.values.size());
}

double BlockComparison::quantile(double fraction) const {
  if (relative.values.empty()) return 0;
  std::vector<float> sorted = relative.values;
  std::sort(sorted.begin(), sorted.end());
  const double rank = std::ceil(std::clamp(fraction, 0., 1.) * static_cast<double>(sorted.size()));
  return sorted[static_cast<std::size_t>(std::max(1., rank)) - 1];
}

ScalarImage relativeErrorMap(const RgbImage& a, const RgbImage& b) {
  constexpr float kFloor = 0.01f;
  requireSameSize(a, b);
  ScalarImage map(a.width, a.height);
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    float sum = 0;
    for (int c = 0; c < 3; ++c)
      sum += std::abs(a.pixels[i][c] - b.pixels[i][c]) / (std::abs(b.pixels[i][c]) + kFloor);
    map.values[i] = a.pixels[i].isFinite() && b.pixels[i].isFinite() ? sum / 3 : kInfinity;
  }
  return map;
}

}  // namespace brume
