// SPDX-License-Identifier: Apache-2.0
// Error against time: pure figures, no files but the images that they come from.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/io/image.h"
#include "tools/bench_entry.h"

namespace brume {

/// An image that is taken as true, and how true it is.
struct Truth {
  RgbImage image;
  std::vector<Rgb> variance;  ///< of each pixel; empty: not known, taken as 0
  /// Mean of variance / (value^2 + 0.01): what the reference's own noise adds to a relMSE.
  double relMseNoise() const;
  /// The same of a relative error's square: mean of variance / (value^2 + kDarkShare mean^2).
  double relativeNoise() const;
};
/// Reads an image with or without variance layers.
Truth readTruth(const std::string& file);

/// Errors at one moment.
struct CurvePoint {
  /// Unbiased estimate of the mean of (a - true)^2 / (true^2 + 0.01): the reference's variance is
  /// subtracted, so it may be negative where the error is below the reference's own noise.
  double relMse = 0;
  /// ImageError::relative, the reference's noise subtracted likewise; 0 where the error is below
  /// it.
  double relative = 0;
  double flip = 0;
  double meanRatio = 1;  ///< of the means over the image and its channels
};
CurvePoint measurePoint(const RgbImage& image, const Truth& truth);

/// One (x, error) of a curve, x > 0.
struct CurveSample {
  double x = 0, error = 0;
};
/// The x at which the error has come down to `target`: on the straight line, in logarithms, between
/// the first point that reaches it and the one before. None when no point does; the first point's x
/// when that already does.
std::optional<double> reach(const std::vector<CurveSample>& curve, double target);
/// Up to `most` errors 1, 0.3, 0.1, 0.03, ... that the curve reaches after its first point, the
/// smallest last.
std::vector<double> targetsOf(const std::vector<CurveSample>& curve, std::size_t most);

}  // namespace brume
