// SPDX-License-Identifier: Apache-2.0
#include "core/io/image.h"

#include <fmt/format.h>

#include <cstring>
#include <filesystem>

#include "core/io/exr_file.h"
#include "core/io/file_bytes.h"
#include "core/io/image_format.h"
#include "core/io/pfm_file.h"
#include "core/io/stb_image_file.h"

namespace brume {
namespace {

/// "unknown image format '.bpm' (did you mean ...); the known are ..."
std::string unknownFormatText(const std::string& path, bool forWriting) {
  std::vector<std::string> known;
  for (const ImageExtension& e : kImageExtensions)
    if (e.isWritable || !forWriting) known.emplace_back(e.text);
  const std::string text = imageExtensionOf(path);
  return fmt::format("{}{}; brume {} {}",
                     text.empty() ? std::string("the name has no extension")
                                  : fmt::format("unknown image format '{}'", text),
                     nearestSpelling(text, known), forWriting ? "writes" : "reads",
                     listChoices(known));
}

RgbImage decodeRgb(ImageFormat format, ByteSpan bytes) {
  return format == ImageFormat::Pfm ? decodePfm(bytes) : decodeStbImage(bytes);
}

LayeredImage toLayered(const RgbImage& image) {
  LayeredImage layered;
  layered.displaySize = {image.width, image.height};
  layered.dataWindow = {{0, 0}, {image.width, image.height}};
  const char* const names[] = {"R", "G", "B"};
  for (int c = 0; c < 3; ++c) {
    std::vector<float>& values = layered.channels[names[c]];
    values.reserve(image.pixels.size());
    for (const Rgb& pixel : image.pixels) values.push_back(pixel[c]);
  }
  return layered;
}

/// Reads the file and hands its bytes to `decode`; every failure becomes "cannot read image 'x':
/// reason" at `where`.
template <class Decode>
auto readWith(const std::string& path, const SourceLocation& where, const Decode& decode) {
  const ImageExtension* extension = findImageExtension(path);
  if (!extension)
    throw SceneError(
        where, fmt::format("cannot read image '{}': {}", path, unknownFormatText(path, false)));
  Bytes bytes;
  try {
    bytes = readFileBytes(path, kMaxImageBytes);
  } catch (const SceneError& e) {
    throw SceneError(where, e.what());
  }
  try {
    if (bytes.empty()) throw SceneError("the file is empty");
    return decode(extension->format, ByteSpan(bytes));
  } catch (const SceneError& e) {
    throw SceneError(where, fmt::format("cannot read image '{}': {}", path, e.what()));
  } catch (const std::bad_alloc&) {
    throw SceneError(where, fmt::format("cannot read image '{}': out of memory", path));
  }
}

bool isColorChannel(const std::string& name) {
  return name == "R" || name == "G" || name == "B" || name == "Y";
}

RgbImage readRgb(const std::string& path, const SourceLocation& where, bool textureOrder) {
  return readWith(path, where, [&](ImageFormat format, ByteSpan bytes) {
    RgbImage image = format == ImageFormat::Exr ? toRgbImage(decodeExr(bytes, path, isColorChannel))
                                                : decodeRgb(format, bytes);
    if (textureOrder && format != ImageFormat::Exr)
      for (int low = 0, high = image.height - 1; low < high; ++low, --high)
        std::swap_ranges(&image.at(0, low), &image.at(0, low) + image.width, &image.at(0, high));
    return image;
  });
}

}  // namespace

LayeredImage readLayeredImage(const std::string& path, const SourceLocation& where) {
  return readWith(path, where, [&](ImageFormat format, ByteSpan bytes) {
    if (format == ImageFormat::Exr) return decodeExr(bytes, path, [](const auto&) { return true; });
    return toLayered(decodeRgb(format, bytes));
  });
}

RgbImage readImage(const std::string& path, const SourceLocation& where) {
  return readRgb(path, where, false);
}

RgbImage readTextureImage(const std::string& path, const SourceLocation& where) {
  return readRgb(path, where, true);
}

RgbImage toRgbImage(const LayeredImage& image) {
  const auto channel = [&](const char* name) -> const std::vector<float>* {
    auto it = image.channels.find(name);
    if (it == image.channels.end()) it = image.channels.find("Y");
    return it == image.channels.end() ? nullptr : &it->second;
  };
  const auto *r = channel("R"), *g = channel("G"), *b = channel("B");
  if (!r || !g || !b) throw SceneError("the image has neither channels R, G, B nor Y");
  RgbImage result(image.dataWindow.width(), image.dataWindow.height());
  for (std::size_t i = 0; i < result.pixels.size(); ++i)
    result.pixels[i] = {(*r)[i], (*g)[i], (*b)[i]};
  return result;
}

HalfLoss lossAsHalves(const LayeredImage& image) {
  constexpr float kSmallestWhole = 0x1p-14f;
  HalfLoss loss;
  float brightest = 0;
  const auto area = static_cast<std::size_t>(image.dataWindow.area());
  for (std::size_t i = 0; i < area; ++i) {
    float largest = 0;
    for (const char* name : {"R", "G", "B"})
      if (const auto channel = image.channels.find(name); channel != image.channels.end())
        largest = std::max(largest, std::abs(channel->second[i]));
    loss.tooBright += std::isfinite(largest) && largest > kLargestHalf ? 1 : 0;
    brightest = std::max(brightest, largest);
  }
  loss.isTooDark = brightest > 0 && brightest < kSmallestWhole;
  return loss;
}

void writeImage(const std::string& path, const LayeredImage& image, PixelPrecision precision) {
  const ImageExtension* extension = findImageExtension(path);
  if (!extension || !extension->isWritable)
    throw SceneError(
        fmt::format("cannot write image '{}': {}", path, unknownFormatText(path, true)));
  if (image.dataWindow.area() == 0)
    throw SceneError(fmt::format("cannot write image '{}': it has no pixels", path));
  AtomicFile file(path);
  if (extension->format == ImageFormat::Exr) {
    writeExr(file, image, precision);
  } else {
    const RgbImage rgb = toRgbImage(image);
    const Bytes bytes = extension->format == ImageFormat::Pfm   ? encodePfm(rgb)
                        : extension->format == ImageFormat::Png ? encodePng(rgb)
                                                                : encodeTga(rgb);
    file.write(bytes.data(), bytes.size());
  }
  file.commit();
}

void writeImage(const std::string& path, const RgbImage& image, PixelPrecision precision) {
  writeImage(path, toLayered(image), precision);
}

bool isWritableImageName(const std::string& path) {
  const ImageExtension* extension = findImageExtension(path);
  return extension && extension->isWritable;
}

void checkWritable(const std::string& path, std::uint64_t bytesNeeded) {
  if (!isWritableImageName(path))
    throw SceneError(
        fmt::format("cannot write image '{}': {}", path, unknownFormatText(path, true)));
  { const AtomicFile probe(path); }
  std::error_code error;
  const std::filesystem::path directory = std::filesystem::path(path).parent_path();
  const auto space = std::filesystem::space(directory.empty() ? "." : directory, error);
  if (!error && space.available < bytesNeeded)
    throw SceneError(fmt::format("cannot write image '{}': {} are free there, {} are needed", path,
                                 formatBytes(static_cast<double>(space.available)),
                                 formatBytes(static_cast<double>(bytesNeeded))));
}

}  // namespace brume
