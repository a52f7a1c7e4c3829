// SPDX-License-Identifier: Apache-2.0
// `brume diff A B`: how far one image is from another.
#pragma once

#include <optional>
#include <string>

namespace brume {

/// What is compared and how much difference is allowed.
struct DiffOptions {
  std::string image, reference;
  /// Side of the squares whose means are compared [pixels]; 1: the pixels themselves. FLIP and the
  /// z-test always look at pixels.
  int block = 1;

  /// Limits; a figure beyond its limit makes the comparison fail.
  std::optional<double> maxMse, maxRelMse, maxMae, minPsnr, maxFlip, maxMeanRatioError;
  std::optional<double> maxBlockError;  ///< relative, for 95 % of the blocks
  std::optional<double> zTest;          ///< family-wise significance level of the per-pixel z-test

  std::string heatmap;  ///< image file for the per-pixel error; empty: none
  bool json = false;
};

struct DiffOutcome {
  std::string text;    ///< a table, or JSON
  bool passed = true;  ///< every figure is within its limit
};

/// Reads both images and compares them. Throws SceneError for unreadable images, different sizes,
/// and a z-test without variance layers.
DiffOutcome compareImageFiles(const DiffOptions& options);

}  // namespace brume
