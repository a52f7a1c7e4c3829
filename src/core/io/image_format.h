// SPDX-License-Identifier: Apache-2.0
// Kinds of image files, told by the name's extension.
#pragma once

#include <array>
#include <string>

namespace brume {

enum class ImageFormat { Exr, Pfm, Png, Tga, Jpeg, Hdr };

struct ImageExtension {
  const char* text;
  ImageFormat format;
  bool isWritable;
};
inline constexpr std::array<ImageExtension, 7> kImageExtensions{
    {{".exr", ImageFormat::Exr, true},
     {".png", ImageFormat::Png, true},
     {".pfm", ImageFormat::Pfm, true},
     {".tga", ImageFormat::Tga, true},
     {".jpg", ImageFormat::Jpeg, false},
     {".jpeg", ImageFormat::Jpeg, false},
     {".hdr", ImageFormat::Hdr, false}}};

/// In lower case, with its point.
std::string imageExtensionOf(const std::string& path);
/// Null for an unknown one.
const ImageExtension* findImageExtension(const std::string& path);

}  // namespace brume
