// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace brume {

/// Writes `text` to `path`; the file appears whole or not at all. Throws SceneError with the
/// reason.
void writeTextFile(const std::string& path, const std::string& text);
/// Throws SceneError when writeTextFile would have no place to write to. Leaves no file.
void checkTextFileWritable(const std::string& path);

}  // namespace brume
