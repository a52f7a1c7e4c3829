// SPDX-License-Identifier: Apache-2.0
#include "core/io/image_format.h"

#include <cctype>
#include <filesystem>

namespace brume {

std::string imageExtensionOf(const std::string& path) {
  std::string text = std::filesystem::path(path).extension().string();
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

const ImageExtension* findImageExtension(const std::string& path) {
  const std::string text = imageExtensionOf(path);
  for (const ImageExtension& e : kImageExtensions)
    if (text == e.text) return &e;
  return nullptr;
}

}  // namespace brume
