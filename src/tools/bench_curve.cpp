// SPDX-License-Identifier: Apache-2.0
#include "tools/bench_curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/film.h"
#include "tools/image_metrics.h"

namespace brume {
namespace {

/// Mean over pixels and channels of variance / (value^2 + dark).
double noise(const Truth& truth, double dark) {
  double sum = 0;
  for (std::size_t i = 0; i < truth.variance.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double value = truth.image.pixels[i][c], variance = truth.variance[i][c];
      if (variance > 0) sum += variance / (value * value + dark);
    }
  return truth.variance.empty() ? 0 : sum / (3 * static_cast<double>(truth.variance.size()));
}

}  // namespace

double Truth::relMseNoise() const { return noise(*this, kRelMseEpsilon); }

double Truth::relativeNoise() const {
  const double mean = meanOf(image);
  return noise(*this, kDarkShare * mean * mean);
}

Truth readTruth(const std::string& file) {
  const LayeredImage layers = readLayeredImage(file);
  Truth truth;
  truth.image = toRgbImage(layers);
  if (!hasVariance(layers)) return truth;
  truth.variance.resize(truth.image.pixels.size());
  for (int c = 0; c < 3; ++c) {
    const std::vector<float>& layer = layers.channels.at(std::string("variance.") + "RGB"[c]);
    for (std::size_t i = 0; i < layer.size(); ++i) {
      if (!std::isfinite(layer[i]))
        throw SceneError(
            fmt::format("the reference '{}' has too few samples to know its noise", file));
      truth.variance[i][c] = layer[i];
    }
  }
  return truth;
}

CurvePoint measurePoint(const RgbImage& image, const Truth& truth) {
  const ImageError error = compareImages(image, truth.image);
  if (error.nonFinitePixels > 0)
    throw SceneError(fmt::format("{} pixels are not finite", error.nonFinitePixels));
  CurvePoint point;
  point.relMse = error.relMse - truth.relMseNoise();
  point.relative = std::sqrt(std::max(0., error.relative * error.relative - truth.relativeNoise()));
  point.flip = flip(image, truth.image).mean;
  double a = 0, b = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    a += error.meanA[c];
    b += error.meanB[c];
  }
  point.meanRatio = a == b ? 1 : a / b;
  return point;
}

std::optional<double> reach(const std::vector<CurveSample>& curve, double target) {
  const auto first = std::find_if(curve.begin(), curve.end(),
                                  [&](const CurveSample& s) { return s.error <= target; });
  if (first == curve.end()) return std::nullopt;
  if (first == curve.begin()) return first->x;
  // An error that is not positive has no logarithm: it counts as a hundredth of the target.
  const CurveSample &before = first[-1], &after = *first;
  const double low = std::max(after.error, 0.01 * target);
  const double share = std::log(before.error / target) / std::log(before.error / low);
  return before.x * std::pow(after.x / before.x, share);
}

std::vector<double> targetsOf(const std::vector<CurveSample>& curve, std::size_t most) {
  std::vector<double> targets;
  if (curve.empty()) return targets;
  double least = curve.front().error;
  for (const CurveSample& s : curve) least = std::min(least, s.error);
  for (int decade = 3; decade >= -12; --decade)
    for (const double digit : {3., 1.}) {
      const double target = digit * std::pow(10., decade);
      if (target < curve.front().error && target >= least && target > 0) targets.push_back(target);
    }
  if (targets.size() > most)
    targets.erase(targets.begin(), targets.end() - static_cast<long>(most));
  return targets;
}

}  // namespace brume
