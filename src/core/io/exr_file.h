// SPDX-License-Identifier: Apache-2.0
// OpenEXR images. The only user of the OpenEXR library.
#pragma once

#include <functional>

#include "core/io/file_bytes.h"
#include "core/io/image.h"

namespace brume {

/// The channels of the first part for which `wanted` is true, as float, and its text attributes.
/// Scan lines or tiles (level 0); deep images and subsampled channels are errors. Throws SceneError
/// with the reason; `name` appears in the library's own messages.
LayeredImage decodeExr(ByteSpan bytes, const std::string& name,
                       const std::function<bool(const std::string&)>& wanted);
/// Scan lines, ZIP compression. Throws SceneError when the file cannot be written.
void writeExr(AtomicFile& file, const LayeredImage& image, PixelPrecision precision);

}  // namespace brume
