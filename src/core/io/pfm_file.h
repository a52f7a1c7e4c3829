// SPDX-License-Identifier: Apache-2.0
// Portable float maps: "PF" or "Pf", width, height, scale (negative: little endian), rows from the
// bottom.
#pragma once

#include <optional>

#include "core/io/file_bytes.h"
#include "core/io/image.h"

namespace brume {

/// Values times |scale|; a one-channel map gives equal channels. Throws SceneError with the reason,
/// without the name of the file.
RgbImage decodePfm(ByteSpan bytes);
/// Width and height of a file of that length that holds all its pixels, by its first bytes.
std::optional<Vec2i> sizeOfWholePfm(ByteSpan head, std::uint64_t fileBytes);
/// Three channels, little endian, scale 1.
Bytes encodePfm(const RgbImage& image);

}  // namespace brume
