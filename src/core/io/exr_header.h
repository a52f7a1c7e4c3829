// SPDX-License-Identifier: Apache-2.0
// A look at the header of an EXR file before the library sees it: the library allocates what the
// header says, so sizes are checked here first.
#pragma once

#include "core/io/file_bytes.h"

namespace brume {

/// Throws SceneError unless the bytes start with a complete EXR header whose attributes, windows,
/// tiles and channels are of believable size for a file of this length.
void checkExrHeader(ByteSpan bytes);

}  // namespace brume
