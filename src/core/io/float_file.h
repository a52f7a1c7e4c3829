// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/error.h"

namespace brume {

/// Reads a text file of numbers separated by blanks, with comments from '#' to the end of the line:
/// spectra (.spd) and the like. Throws SceneError: at `blame` when the file cannot be read, at its
/// place in the file for anything that is no finite number.
std::vector<float> readFloatFile(const std::string& path, const SourceLocation& blame);

}  // namespace brume
