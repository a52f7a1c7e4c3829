// SPDX-License-Identifier: Apache-2.0
// What can be known of an image file without decoding it.
#pragma once

#include <optional>
#include <string>

#include "core/math.h"

namespace brume {

/// Width and height of an image file, when its head and its end show that reading it later will
/// hardly fail: it is there, of the kind that its name says, of a size that is read, and complete.
/// Run-length coded TGA and HDR files, which say nowhere how long they are, are walked through.
/// None in every doubt (no such file, a pipe, something unusual or wrong): then readImage tells.
std::optional<Vec2i> sizeOfWholeImage(const std::string& path);

}  // namespace brume
