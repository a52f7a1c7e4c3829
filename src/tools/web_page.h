// SPDX-License-Identifier: Apache-2.0
// Parts of HTML pages that open from disk and need nothing beside themselves.
#pragma once

#include <string>

#include "core/io/image.h"

namespace brume {

/// "data:image/png;base64,..." with sRGB values, for <img src>.
std::string pngUri(const RgbImage& image);
/// Text that stands for itself in HTML and in its attributes.
std::string escapeHtml(const std::string& text);

}  // namespace brume
