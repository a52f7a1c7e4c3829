// SPDX-License-Identifier: Apache-2.0
#include "core/io/stb_image_file.h"

#include <fmt/format.h>

#include <memory>

#include "core/io/image_integrity.h"
#include "core/io/image_limits.h"
#include "core/srgb.h"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_TGA
#define STBI_ONLY_HDR
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS (1 << 18)
#include <stb_image.h>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#include <stb_image_write.h>

namespace brume {
namespace {

static_assert(STBI_MAX_DIMENSIONS == kMaxImageSide);

struct StbFree {
  void operator()(void* pixels) const { stbi_image_free(pixels); }
};
template <class T>
using StbPixels = std::unique_ptr<T, StbFree>;

template <class T>
RgbImage toImage(const StbPixels<T>& from, int width, int height, float white) {
  if (!from) throw SceneError(fmt::format("corrupt image file: {}", stbi_failure_reason()));
  RgbImage image(width, height);
  const T* source = from.get();
  for (Rgb& pixel : image.pixels) {
    pixel = {static_cast<float>(source[0]) / white, static_cast<float>(source[1]) / white,
             static_cast<float>(source[2]) / white};
    source += 3;
  }
  return image;
}

void appendBytes(void* target, void* data, int size) {
  const auto* first = static_cast<const unsigned char*>(data);
  auto& bytes = *static_cast<Bytes*>(target);
  bytes.insert(bytes.end(), first, first + size);
}

Bytes toSrgb8(const RgbImage& image) {
  constexpr std::size_t kMaxBytes = std::size_t{1} << 30;  // the encoders count in int
  if (image.pixels.size() * 3 > kMaxBytes)
    throw SceneError(fmt::format("{} x {} pixels are too many for an 8-bit file; write an .exr",
                                 image.width, image.height));
  Bytes bytes;
  bytes.reserve(image.pixels.size() * 3);
  for (const Rgb& pixel : image.pixels)
    for (int c = 0; c < 3; ++c) bytes.push_back(encodeSrgb8(pixel[c]));
  return bytes;
}

}  // namespace

RgbImage decodeStbImage(ByteSpan bytes) {
  constexpr std::size_t kMaxFileBytes = std::size_t{1} << 30;  // the decoder counts in int
  if (bytes.size() > kMaxFileBytes)
    throw SceneError(fmt::format("the file is too large: {}; the limit for this format is {}",
                                 formatBytes(static_cast<double>(bytes.size())),
                                 formatBytes(static_cast<double>(kMaxFileBytes))));
  const StbFormat format = detectStbFormat(bytes);
  const int size = static_cast<int>(bytes.size());
  int width = 0, height = 0, components = 0;
  // Integrity first: it leaves nothing for the decoder's header code to stumble over.
  checkIntegrity(format, bytes);
  if (!stbi_info_from_memory(bytes.data(), size, &width, &height, &components))
    throw SceneError(fmt::format("corrupt image file: {}", stbi_failure_reason()));
  checkImageSize(width, height, sizeof(Rgb), bytes.size(), maxCompression(format));

  int n = 0;
  const unsigned char* data = bytes.data();
  if (format == StbFormat::Hdr) {
    const StbPixels<float> pixels(stbi_loadf_from_memory(data, size, &width, &height, &n, 3));
    return toImage(pixels, width, height, 1.f);
  }
  if (stbi_is_16_bit_from_memory(data, size)) {
    const StbPixels<stbi_us> pixels(stbi_load_16_from_memory(data, size, &width, &height, &n, 3));
    return toImage(pixels, width, height, 65535.f);
  }
  const StbPixels<stbi_uc> pixels(stbi_load_from_memory(data, size, &width, &height, &n, 3));
  return toImage(pixels, width, height, 255.f);
}

Bytes encodePng(const RgbImage& image) {
  const Bytes pixels = toSrgb8(image);
  Bytes bytes;
  if (!stbi_write_png_to_func(appendBytes, &bytes, image.width, image.height, 3, pixels.data(),
                              3 * image.width))
    throw SceneError("cannot encode the image as PNG");
  return bytes;
}

Bytes encodeTga(const RgbImage& image) {
  constexpr int kMaxSide = 65535;
  if (image.width > kMaxSide || image.height > kMaxSide)
    throw SceneError(fmt::format("a TGA file holds at most {} pixels a side", kMaxSide));
  const Bytes pixels = toSrgb8(image);
  Bytes bytes;
  if (!stbi_write_tga_to_func(appendBytes, &bytes, image.width, image.height, 3, pixels.data()))
    throw SceneError("cannot encode the image as TGA");
  return bytes;
}

}  // namespace brume
