// SPDX-License-Identifier: Apache-2.0
#include "core/io/image_integrity.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "core/error.h"
#include "core/io/crc32.h"
#include "core/io/image_limits.h"
#include "core/io/jpeg_integrity.h"

namespace brume {
namespace {

[[noreturn]] void truncated(const char* format) {
  throw SceneError(fmt::format("truncated {} file", format));
}

bool startsWith(ByteSpan bytes, std::string_view prefix) {
  return bytes.size() >= prefix.size() &&
         std::equal(prefix.begin(), prefix.end(), bytes.begin(),
                    [](char a, unsigned char b) { return static_cast<unsigned char>(a) == b; });
}

std::uint32_t bigEndian32(ByteSpan b) {
  return std::uint32_t{b[0]} << 24 | std::uint32_t{b[1]} << 16 | std::uint32_t{b[2]} << 8 | b[3];
}

/// Signature, then chunks of length, type, data and checksum up to IEND.
void checkPng(ByteSpan bytes) {
  for (std::size_t at = 8;;) {
    if (bytes.size() - at < 12) truncated("PNG");
    const std::size_t length = bigEndian32(bytes.subspan(at, 4));
    if (length > bytes.size() - at - 12) truncated("PNG");
    const ByteSpan typeAndData = bytes.subspan(at + 4, length + 4);
    if (crc32(typeAndData) != bigEndian32(bytes.subspan(at + 8 + length, 4)))
      throw SceneError(fmt::format("corrupt PNG file: wrong checksum of the chunk at byte {}", at));
    if (startsWith(typeAndData, "IEND")) return;
    at += 12 + length;
  }
}

struct TgaHeader {
  unsigned idLength, mapType, imageType, mapLength, mapBits, width, height, bits;
  std::size_t pixelStart() const { return 18 + idLength + mapLength * ((mapBits + 7) / 8); }
};
constexpr std::size_t kTgaHeaderSize = 18;

TgaHeader readTgaHeader(ByteSpan b) {
  const auto u16 = [&](std::size_t i) { return b[i] | static_cast<unsigned>(b[i + 1]) << 8; };
  const unsigned mapLength = b[1] ? u16(5) : 0;
  return {b[0], b[1], b[2], mapLength, b[7], u16(12), u16(14), b[16]};
}

bool isPlausibleTga(ByteSpan bytes) {
  if (bytes.size() < kTgaHeaderSize) return false;
  const TgaHeader h = readTgaHeader(bytes);
  const bool mapped = h.imageType == 1 || h.imageType == 9;
  const bool coloured = h.imageType == 2 || h.imageType == 10;
  const bool grey = h.imageType == 3 || h.imageType == 11;
  if (h.width == 0 || h.height == 0 || h.mapType > 1 || (!mapped && !coloured && !grey))
    return false;
  if (mapped && (h.mapType != 1 || h.mapLength == 0)) return false;
  if (h.mapType == 1 && h.mapBits != 15 && h.mapBits != 16 && h.mapBits != 24 && h.mapBits != 32)
    return false;
  if (coloured) return h.bits == 15 || h.bits == 16 || h.bits == 24 || h.bits == 32;
  return h.bits == 8 || (h.bits == 16 && grey);
}

/// Pixels stored plainly, or as packets: a byte with count - 1 and a run flag, then one or count
/// pixels.
void checkTga(ByteSpan bytes) {
  const TgaHeader h = readTgaHeader(bytes);
  const std::size_t pixelBytes = (h.bits + 7) / 8;
  const std::size_t pixels = std::size_t{h.width} * h.height;
  std::size_t at = h.pixelStart();
  if (h.imageType < 8) {
    if (bytes.size() < at || bytes.size() - at < pixels * pixelBytes) truncated("TGA");
    return;
  }
  for (std::size_t done = 0; done < pixels;) {
    if (at >= bytes.size()) truncated("TGA");
    const std::size_t count = (bytes[at] & 0x7fu) + 1u;
    at += 1 + (bytes[at] & 0x80u ? 1 : count) * pixelBytes;
    done += count;
    if (at > bytes.size()) truncated("TGA");
  }
}

/// One line of the text header; `at` moves behind its end.
std::string_view nextLine(ByteSpan bytes, std::size_t& at) {
  const std::size_t start = at;
  while (at < bytes.size() && bytes[at] != '\n') ++at;
  if (at >= bytes.size()) truncated("HDR");
  return {reinterpret_cast<const char*>(bytes.data()) + start, at++ - start};
}

/// Run-length coded scan line of `width` pixels: four planes of runs and literals.
void skipHdrScanline(ByteSpan bytes, std::size_t& at, int width) {
  if (bytes.size() - at < 4) truncated("HDR");
  if (bytes[at] != 2 || bytes[at + 1] != 2 || (bytes[at + 2] << 8 | bytes[at + 3]) != width)
    throw SceneError("corrupt HDR file: bad start of a scan line");
  at += 4;
  for (int plane = 0; plane < 4; ++plane)
    for (int done = 0; done < width;) {
      if (at >= bytes.size()) truncated("HDR");
      const int code = bytes[at++];
      const int count = code > 128 ? code - 128 : code;
      if (count == 0 || count > width - done) throw SceneError("corrupt HDR file: bad run length");
      at += code > 128 ? 1 : static_cast<std::size_t>(count);
      done += count;
      if (at > bytes.size()) truncated("HDR");
    }
}

void checkHdr(ByteSpan bytes) {
  std::size_t at = 0;
  while (!nextLine(bytes, at).empty()) {
  }
  int width = 0, height = 0;
  const std::string resolution(nextLine(bytes, at));
  if (std::sscanf(resolution.c_str(), "-Y %d +X %d", &height, &width) != 2)
    throw SceneError("HDR files must have their rows from the top ('-Y height +X width')");
  // A run of 127 equal bytes takes two.
  checkImageSize(width, height, 12, bytes.size(), 12. / 4 * 64);

  const bool codable = width >= 8 && width < 32768;
  const bool coded = codable && bytes.size() - at >= 4 && bytes[at] == 2 && bytes[at + 1] == 2 &&
                     bytes[at + 2] < 128;
  if (coded) {
    for (int y = 0; y < height; ++y) skipHdrScanline(bytes, at, width);
  } else if ((bytes.size() - at) / 4 / static_cast<std::size_t>(width) <
             static_cast<std::size_t>(height)) {
    truncated("HDR");
  }
}

}  // namespace

StbFormat detectStbFormat(ByteSpan bytes) {
  if (startsWith(bytes, "\x89PNG\r\n\x1a\n")) return StbFormat::Png;
  if (startsWith(bytes, "\xff\xd8\xff")) return StbFormat::Jpeg;
  if (startsWith(bytes, "#?RADIANCE\n") || startsWith(bytes, "#?RGBE\n")) return StbFormat::Hdr;
  if (isPlausibleTga(bytes)) return StbFormat::Tga;
  throw SceneError("not a PNG, JPEG, TGA or HDR file");
}

void checkIntegrity(StbFormat format, ByteSpan bytes) {
  switch (format) {
    case StbFormat::Png:
      return checkPng(bytes);
    case StbFormat::Jpeg:
      return checkJpeg(bytes);
    case StbFormat::Tga:
      return checkTga(bytes);
    case StbFormat::Hdr:
      return checkHdr(bytes);
  }
}

double maxCompression(StbFormat format) {
  constexpr double kFloatPerByte = 4;  // decoded by the library to 8 bits a channel, then widened
  switch (format) {
    case StbFormat::Png:
      return kFloatPerByte * 1032 * 24;  // deflate on 1-bit pixels, decoded to 3 bytes each
    case StbFormat::Jpeg:
      return kFloatPerByte * 8192;  // a flat 8x8 block of 192 bytes in a few bits
    case StbFormat::Tga:
      return kFloatPerByte * 3 * 64;  // runs of 128 pixels in 2 bytes
    case StbFormat::Hdr:
      return kFloatPerByte * 3 * 64;
  }
  return 1;
}

namespace {

/// The first chunk of a PNG file.
std::optional<Vec2i> pngSize(ByteSpan head) {
  constexpr std::size_t kHeaderEnd = 8 + 12 + 13;
  if (head.size() < kHeaderEnd || bigEndian32(head.subspan(8)) != 13 ||
      !startsWith(head.subspan(12), "IHDR"))
    return std::nullopt;
  const ByteSpan data = head.subspan(16);
  const int bits = data[8], colour = data[9];
  const bool isUsual = (bits == 1 || bits == 2 || bits == 4 || bits == 8 || bits == 16) &&
                       (colour == 0 || colour == 2 || colour == 3 || colour == 4 || colour == 6) &&
                       data[10] == 0 && data[11] == 0 && data[12] <= 1;
  const std::uint32_t width = bigEndian32(data), height = bigEndian32(data.subspan(4));
  if (!isUsual || width > kMaxImageSide || height > kMaxImageSide) return std::nullopt;
  return Vec2i(static_cast<int>(width), static_cast<int>(height));
}

/// The frame segment of a JPEG file: baseline, extended or progressive, 8 bits, grey or colour.
std::optional<Vec2i> jpegSize(ByteSpan head) {
  const auto u16 = [&](std::size_t i) { return int{head[i]} << 8 | head[i + 1]; };
  for (std::size_t at = 2; at + 10 <= head.size();) {
    if (head[at] != 0xff) return std::nullopt;
    const unsigned char marker = head[at + 1];
    if (marker == 0xff) {
      ++at;  // fill bytes
      continue;
    }
    if (marker >= 0xc0 && marker <= 0xc2) {
      const int bits = head[at + 4], channels = head[at + 9];
      if (bits != 8 || (channels != 1 && channels != 3)) return std::nullopt;
      return Vec2i(u16(at + 7), u16(at + 5));
    }
    // Tables and comments go before the frame, nothing else.
    const bool isSegment = marker == 0xc4 || marker == 0xdb || marker == 0xdd || marker >= 0xe0;
    if (!isSegment) return std::nullopt;
    at += 2 + static_cast<std::size_t>(u16(at + 2));
  }
  return std::nullopt;
}

std::optional<Vec2i> hdrSize(ByteSpan head) {
  try {
    std::size_t at = 0;
    while (!nextLine(head, at).empty()) {
    }
    int width = 0, height = 0;
    const std::string resolution(nextLine(head, at));
    if (std::sscanf(resolution.c_str(), "-Y %d +X %d", &height, &width) == 2)
      return Vec2i(width, height);
  } catch (const SceneError&) {
  }
  return std::nullopt;
}

}  // namespace

std::optional<Vec2i> sizeInHead(StbFormat format, ByteSpan head) {
  switch (format) {
    case StbFormat::Png:
      return pngSize(head);
    case StbFormat::Jpeg:
      return jpegSize(head);
    case StbFormat::Tga:
      if (!isPlausibleTga(head)) return std::nullopt;
      return Vec2i(static_cast<int>(readTgaHeader(head).width),
                   static_cast<int>(readTgaHeader(head).height));
    case StbFormat::Hdr:
      return hdrSize(head);
  }
  return std::nullopt;
}

bool hasProperEnd(StbFormat format, ByteSpan head, ByteSpan tail, std::uint64_t fileBytes) {
  const auto endsWith = [&](std::string_view text) {
    return tail.size() >= text.size() && startsWith(tail.last(text.size()), text);
  };
  switch (format) {
    case StbFormat::Png:
      return endsWith(std::string_view("\0\0\0\0IEND\xae\x42\x60\x82", 12));
    case StbFormat::Jpeg:
      return endsWith("\xff\xd9");
    case StbFormat::Tga: {
      const TgaHeader h = readTgaHeader(head);
      const std::uint64_t pixels = std::uint64_t{h.width} * h.height;
      return h.imageType < 8 && fileBytes >= h.pixelStart() + pixels * ((h.bits + 7) / 8);
    }
    case StbFormat::Hdr:
      break;
  }
  return false;
}

}  // namespace brume
