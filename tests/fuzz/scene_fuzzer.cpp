// SPDX-License-Identifier: Apache-2.0
// Any bytes as a scene file: parsed with all plugins of the world block made. What may come out is
// frames or a SceneError, nothing else.
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/log.h"
#include "core/parse/scene_description.h"

namespace {

/// Relative names lead into this folder, which stays empty.
const std::string& emptyFolder() {
  static const std::string folder = [] {
    std::string name = (std::filesystem::temp_directory_path() / "brume-fuzz-XXXXXX").string();
    if (!mkdtemp(name.data())) std::abort();
    return name;
  }();
  return folder;
}

/// Whether a string of the text could name a file outside of the empty folder: by a slash, or by
/// an escape that may stand for one.
bool mayLeaveFolder(std::string_view text) {
  if (text.find('/') != std::string_view::npos) return true;
  for (std::size_t i = text.find('\\'); i != std::string_view::npos; i = text.find('\\', i + 1))
    if (i + 1 < text.size() && text[i + 1] >= '0' && text[i + 1] <= '9') return true;
  return false;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  constexpr std::size_t kLongest = 1 << 16;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (size > kLongest || mayLeaveFolder(text)) return -1;  // not for the corpus
  brume::Log log({brume::Verbosity::Quiet, false, true});
  try {
    brume::parseSceneText(text, "fuzz.pbrt", emptyFolder(), {}, log,
                          [](brume::SceneDescription) {});
  } catch (const brume::SceneError& error) {
    // The message must be printable whatever the place.
    static_cast<void>(brume::formatDiagnostic(error.where(), "error", error.what()));
  }
  return 0;
}
