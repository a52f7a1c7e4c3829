// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/io/file_bytes.h"

namespace brume {

/// Walks over the segments of a JPEG file up to its end marker. Throws SceneError when it is
/// truncated, when a Huffman table has more codes than there are values, or when a scan uses a
/// table that was not defined: the decoder would read or write outside its tables.
void checkJpeg(ByteSpan bytes);

}  // namespace brume
