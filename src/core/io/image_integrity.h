// SPDX-License-Identifier: Apache-2.0
// Completeness of PNG, JPEG, TGA and HDR files. The decoder reads on past a truncated end with
// zeros and ignores checksums; these walks over the file structure find what it would miss.
#pragma once

#include "core/io/file_bytes.h"

namespace brume {

enum class StbFormat { Png, Jpeg, Tga, Hdr };

/// From the first bytes; TGA, which has no signature, when its header is plausible. Throws
/// SceneError for anything else.
StbFormat detectStbFormat(ByteSpan bytes);
/// Throws SceneError for a file that is truncated or (PNG) fails its checksums.
void checkIntegrity(StbFormat format, ByteSpan bytes);

}  // namespace brume
