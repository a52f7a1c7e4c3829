// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/io/image.h"
#include "tools/image_metrics.h"
#include "tools/regress.h"

namespace brume {

/// What a comparison by RegressRules found.
struct RegressVerdict {
  std::vector<std::string> failures;
  std::string figures;       ///< one line
  ScalarImage pValues;       ///< of the pixels; empty without a z-test
  ScalarImage blockPValues;  ///< of the blocks; empty where they are not tested
};

/// Compares an image and its reference, both with variance layers when there is a z-test. The
/// z-test looks at pixels, at means of blocks and at the mean of the image; each gets a third of
/// the chance of a false alarm. Throws SceneError when the images cannot be compared.
///
/// The variance of a pixel that is estimated from few samples is too small where bright ones are
/// rare. In the test of pixels it counts as at least what the samples of the reference would give;
/// means of blocks have samples enough.
RegressVerdict judge(const LayeredImage& image, const LayeredImage& reference,
                     const RegressRules& rules);

}  // namespace brume
