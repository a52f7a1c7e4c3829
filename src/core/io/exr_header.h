// SPDX-License-Identifier: Apache-2.0
// A look at the header of an EXR file before the library sees it: the library allocates what the
// header says, so sizes are checked here first.
#pragma once

#include <optional>

#include "core/io/file_bytes.h"
#include "core/math.h"

namespace brume {

/// Throws SceneError unless the bytes start with a complete EXR header whose attributes, windows,
/// tiles and channels are of believable size for a file of this length.
void checkExrHeader(ByteSpan bytes);

/// Width and height of a file with colour channels that is complete by its table of chunks: all are
/// there and the last one ends inside of the file. None where that cannot be told from header and
/// table, or the file is of a rare kind (several parts, mip maps): then only decoding it tells.
std::optional<Vec2i> sizeOfWholeExr(const FilePieces& file, ByteSpan head);

}  // namespace brume
