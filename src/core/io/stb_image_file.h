// SPDX-License-Identifier: Apache-2.0
// PNG, JPEG, TGA and HDR images. The only user of the stb libraries.
#pragma once

#include "core/io/file_bytes.h"
#include "core/io/image.h"

namespace brume {

/// 8-bit values / 255, 16-bit values / 65535, no gamma decode; grey gives equal channels, alpha is
/// ignored; HDR is linear. The format is told from the bytes. Throws SceneError with the reason.
RgbImage decodeStbImage(ByteSpan bytes);
/// 8 bits per channel with the sRGB curve, clipped to [0, 1], NaN black.
Bytes encodePng(const RgbImage& image);
Bytes encodeTga(const RgbImage& image);

}  // namespace brume
