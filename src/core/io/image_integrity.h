// SPDX-License-Identifier: Apache-2.0
// Completeness of PNG, JPEG, TGA and HDR files. The decoder reads on past a truncated end with
// zeros and ignores checksums; these walks over the file structure find what it would miss.
#pragma once

#include <optional>

#include "core/io/file_bytes.h"
#include "core/math.h"

namespace brume {

enum class StbFormat { Png, Jpeg, Tga, Hdr };

/// From the first bytes; TGA, which has no signature, when its header is plausible. Throws
/// SceneError for anything else.
StbFormat detectStbFormat(ByteSpan bytes);
/// Throws SceneError for a file that is truncated or (PNG) fails its checksums.
void checkIntegrity(StbFormat format, ByteSpan bytes);

/// Bytes of pixels as floats, three channels each, that one byte of a file can hold at most.
double maxCompression(StbFormat format);

/// Width and height from a file's first bytes; none when they do not tell, or tell of something
/// unusual.
std::optional<Vec2i> sizeInHead(StbFormat format, ByteSpan head);
/// Whether length and last bytes show that a file whose head is usual ends where it should. False
/// where only checkIntegrity tells.
bool hasProperEnd(StbFormat format, ByteSpan head, ByteSpan tail, std::uint64_t fileBytes);
/// As many last bytes as hasProperEnd looks at.
inline constexpr std::size_t kTailBytes = 12;

}  // namespace brume
