// SPDX-License-Identifier: Apache-2.0
// Portable float maps: "PF" or "Pf", width, height, scale (negative: little endian), rows from the
// bottom.
#pragma once

#include "core/io/file_bytes.h"
#include "core/io/image.h"

namespace brume {

/// Values times |scale|; a one-channel map gives equal channels. Throws SceneError with the reason,
/// without the name of the file.
RgbImage decodePfm(ByteSpan bytes);
/// Three channels, little endian, scale 1.
Bytes encodePfm(const RgbImage& image);

}  // namespace brume
