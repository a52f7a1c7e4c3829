// SPDX-License-Identifier: Apache-2.0
// Renders a scene that is given as text, for tests.
#pragma once

#include <string>

#include "renderers/render_job.h"

namespace brume {

/// The first frame of a scene text, ready to be run; warnings go to `log`.
std::unique_ptr<RenderJob> makeJob(const std::string& text, const RenderSettings& settings,
                                   Log& log);
/// Renders the first frame of the text.
RenderResult renderText(const std::string& text, const RenderSettings& settings = {});
Rgb pixelOf(const LayeredImage& image, int x, int y);
/// Mean over all pixels, in double.
Rgb meanOf(const LayeredImage& image);

}  // namespace brume
