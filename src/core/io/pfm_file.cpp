// SPDX-License-Identifier: Apache-2.0
#include "core/io/pfm_file.h"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "core/io/image_limits.h"

namespace brume {
namespace {

bool isSpace(unsigned char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/// The next word of the header; one separator behind it is consumed too.
std::string_view nextWord(ByteSpan bytes, std::size_t& position) {
  while (position < bytes.size() && isSpace(bytes[position])) ++position;
  const std::size_t start = position;
  while (position < bytes.size() && !isSpace(bytes[position])) ++position;
  const std::string_view word(reinterpret_cast<const char*>(bytes.data()) + start,
                              position - start);
  if (position >= bytes.size()) throw SceneError("truncated header of a PFM file");
  ++position;
  return word;
}

template <class T>
T number(std::string_view word, const char* what) {
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size())
    throw SceneError(fmt::format("PFM header: the {} is not a number", what));
  return value;
}

float loadFloat(const unsigned char* bytes, bool swapped) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, bytes, 4);
  if (swapped) bits = __builtin_bswap32(bits);
  return std::bit_cast<float>(bits);
}

struct PfmHeader {
  std::size_t channels, width, height;
  float scale;
  std::size_t pixelStart;
  std::size_t pixelBytes() const { return 4 * channels * width * height; }
};

/// The header of a file of that length, which `bytes` are the first of.
PfmHeader readPfmHeader(ByteSpan bytes, std::uint64_t fileBytes) {
  if (bytes.size() < 3 || bytes[0] != 'P' || (bytes[1] != 'F' && bytes[1] != 'f') ||
      !isSpace(bytes[2]))
    throw SceneError("not a PFM file");
  const std::size_t channels = bytes[1] == 'F' ? 3 : 1;
  std::size_t position = 3;
  const auto width = number<std::int64_t>(nextWord(bytes, position), "width");
  const auto height = number<std::int64_t>(nextWord(bytes, position), "height");
  const auto scale = number<float>(nextWord(bytes, position), "scale");
  if (!std::isfinite(scale) || scale == 0.f)
    throw SceneError("PFM header: the scale is 0 or not finite");
  checkImageSize(width, height, sizeof(Rgb), fileBytes, 3);
  return {channels, static_cast<std::size_t>(width), static_cast<std::size_t>(height), scale,
          position};
}

}  // namespace

std::optional<Vec2i> sizeOfWholePfm(ByteSpan head, std::uint64_t fileBytes) {
  try {
    const PfmHeader h = readPfmHeader(head, fileBytes);
    if (fileBytes < h.pixelStart + h.pixelBytes()) return std::nullopt;
    return Vec2i(static_cast<int>(h.width), static_cast<int>(h.height));
  } catch (const SceneError&) {
    return std::nullopt;
  }
}

RgbImage decodePfm(ByteSpan bytes) {
  const PfmHeader header = readPfmHeader(bytes, bytes.size());
  const std::size_t w = header.width, h = header.height, channels = header.channels;
  const std::size_t position = header.pixelStart;
  if (bytes.size() - position < header.pixelBytes())
    throw SceneError(fmt::format("truncated PFM file: {} bytes of pixels instead of {}",
                                 bytes.size() - position, header.pixelBytes()));
  const bool swapped = (header.scale < 0.f) != (std::endian::native == std::endian::little);
  const float factor = std::abs(header.scale);
  RgbImage image(static_cast<int>(w), static_cast<int>(h));
  for (std::size_t row = 0; row < h; ++row) {
    const unsigned char* source = bytes.data() + position + 4 * channels * w * (h - 1 - row);
    Rgb* target = image.pixels.data() + row * w;
    for (std::size_t x = 0; x < w; ++x, source += 4 * channels) {
      const float first = loadFloat(source, swapped);
      target[x] = channels == 1
                      ? Rgb(first)
                      : Rgb(first, loadFloat(source + 4, swapped), loadFloat(source + 8, swapped));
      if (factor != 1.f) target[x] *= factor;
    }
  }
  return image;
}

Bytes encodePfm(const RgbImage& image) {
  const std::string header = fmt::format("PF\n{} {}\n-1.0\n", image.width, image.height);
  const auto w = static_cast<std::size_t>(image.width), h = static_cast<std::size_t>(image.height);
  Bytes bytes(header.size() + 12 * w * h);
  std::memcpy(bytes.data(), header.data(), header.size());
  unsigned char* target = bytes.data() + header.size();
  for (std::size_t row = h; row-- > 0;)
    for (std::size_t x = 0; x < w; ++x)
      for (int c = 0; c < 3; ++c, target += 4) {
        auto bits = std::bit_cast<std::uint32_t>(image.pixels[row * w + x][c]);
        if constexpr (std::endian::native == std::endian::big) bits = __builtin_bswap32(bits);
        std::memcpy(target, &bits, 4);
      }
  return bytes;
}

}  // namespace brume
