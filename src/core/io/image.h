// SPDX-License-Identifier: Apache-2.0
// Images in memory and their files: EXR (all channels, metadata), PNG, PFM, TGA, JPEG, HDR.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/math.h"
#include "core/rgb.h"

namespace brume {

/// RGB floats, linear, row-major, first row at the top.
struct RgbImage {
  int width = 0, height = 0;
  std::vector<Rgb> pixels;

  RgbImage() = default;
  RgbImage(int w, int h)
      : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  Rgb& at(int x, int y) {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
  const Rgb& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

/// An image with any number of named channels ("R", "variance.R", "depth.Z", ...), a data window
/// inside a display window, and text metadata: what an EXR file holds.
struct LayeredImage {
  Vec2i displaySize{0};  ///< full resolution
  Bounds2i dataWindow;   ///< pixels that are stored
  std::map<std::string, std::vector<float>>
      channels;  ///< each dataWindow.area() values, row-major from the top
  std::map<std::string, std::string> metadata;

  bool has(const std::string& channel) const { return channels.count(channel) != 0; }
};

/// Half: of colours; depths, variances and numbers of samples are written as floats.
enum class PixelPrecision { Half, Float };

/// What R, G and B of an image lose as halves.
struct HalfLoss {
  std::size_t tooBright = 0;  ///< pixels beyond kLargestHalf, which they are stored as
  bool isTooDark = false;     ///< no value reaches the smallest half with all digits, 2^-14
};
inline constexpr float kLargestHalf = 65504.f;
HalfLoss lossAsHalves(const LayeredImage& image);

/// Reads the file by its extension (.exr .png .pfm .tga .jpg .jpeg .hdr, in either case). EXR: all
/// channels; the others R, G, B (8-bit values / 255, 16-bit / 65535, no gamma decode). Throws
/// SceneError at `where` with the reason for a missing, foreign, truncated, corrupt or oversized
/// file (kMaxImageBytes, and a header that promises more than the file can hold).
LayeredImage readLayeredImage(const std::string& path, const SourceLocation& where = {});
/// R, G, B of the above (a lone luminance channel Y is copied to all three), the data window only;
/// other channels are not decoded.
RgbImage readImage(const std::string& path, const SourceLocation& where = {});
/// readImage with the row of texture coordinate t = 0 first, as PBRT-v2 has it: the top row of an
/// EXR file, the bottom row of TGA and PFM. PBRT-v2 does not read PNG, JPEG and HDR; as its users
/// replaced TGA files by them, they are treated as TGA.
RgbImage readTextureImage(const std::string& path, const SourceLocation& where = {});
/// R, G, B of the data window (a lone Y in all three). Throws SceneError when there is neither.
RgbImage toRgbImage(const LayeredImage& image);

/// Writes by extension: .exr (everything), .pfm (float RGB), .png (sRGB), .tga (sRGB); all but .exr
/// hold R, G, B of the data window. The file appears whole or not at all: it is written beside its
/// place and renamed. With PixelPrecision::Half finite colours beyond 65504 are stored as +-65504.
/// Throws SceneError with the reason.
void writeImage(const std::string& path, const LayeredImage& image,
                PixelPrecision precision = PixelPrecision::Float);
void writeImage(const std::string& path, const RgbImage& image,
                PixelPrecision precision = PixelPrecision::Float);
/// Whether `path` has an extension that writeImage knows.
bool isWritableImageName(const std::string& path);
/// Throws SceneError when `path` cannot be written: directory missing or read-only, or less than
/// `bytesNeeded` free there. Leaves no file.
void checkWritable(const std::string& path, std::uint64_t bytesNeeded = 1);

/// Decoded pixels of one image may take this much memory.
inline constexpr std::uint64_t kMaxImageBytes = std::uint64_t{8} << 30;

}  // namespace brume
