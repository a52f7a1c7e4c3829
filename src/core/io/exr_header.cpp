// SPDX-License-Identifier: Apache-2.0
// Layout: OpenEXR File Layout, https://openexr.com (magic, version and flags, attributes of name,
// type, size, data).
#include "core/io/exr_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "core/error.h"
#include "core/io/image_limits.h"

namespace brume {
namespace {

// Deflate reaches 1032:1 and halves become floats; the wavelet codec does a little better on
// constant images.
constexpr double kMaxCompression = 8192;
constexpr std::uint32_t kMagic = 0x01312f76;
constexpr std::uint32_t kTiledFlag = 0x200, kDeepFlag = 0x800, kMultiPartFlag = 0x1000;
constexpr std::size_t kMaxChannels = 1024;
constexpr std::uint64_t kMaxTileBytes = std::uint64_t{1} << 28;

class Cursor {
 public:
  explicit Cursor(ByteSpan bytes) : bytes_(bytes) {}

  std::size_t left() const { return bytes_.size() - position_; }
  std::uint32_t u32() {
    const ByteSpan b = take(4);
    return b[0] | std::uint32_t{b[1]} << 8 | std::uint32_t{b[2]} << 16 | std::uint32_t{b[3]} << 24;
  }
  std::int32_t i32() { return static_cast<std::int32_t>(u32()); }
  /// Up to the next zero byte, which is consumed.
  std::string_view text() {
    constexpr std::size_t kMaxName = 255;
    const ByteSpan rest = bytes_.subspan(position_);
    const auto end = std::find(rest.begin(), rest.end(), 0);
    const auto length = static_cast<std::size_t>(end - rest.begin());
    if (end == rest.end()) truncated();
    if (length > kMaxName) throw SceneError("corrupt EXR header: a name is too long");
    position_ += length + 1;
    return {reinterpret_cast<const char*>(rest.data()), length};
  }
  ByteSpan take(std::size_t size) {
    if (size > left()) truncated();
    position_ += size;
    return bytes_.subspan(position_ - size, size);
  }
  std::size_t position() const { return position_; }
  bool atEmptyText() const { return left() > 0 && bytes_[position_] == 0; }

 private:
  [[noreturn]] static void truncated() { throw SceneError("truncated EXR header"); }

  ByteSpan bytes_;
  std::size_t position_ = 0;
};

struct Part {
  std::int64_t width = 0, height = 0;
  std::size_t channels = 0;
  bool hasColour = false;  ///< R, G, B or Y, one value for each pixel
  std::uint64_t tileWidth = 0, tileHeight = 0, tilePixels = 0;
  unsigned tileMode = 0, compression = 0;
};

void readChannels(ByteSpan list, Part& part) {
  Cursor cursor(list);
  int colours = 0;
  bool hasLuminance = false, isSubsampled = false;
  for (;;) {
    const std::string_view name = cursor.text();
    if (name.empty()) break;
    cursor.take(8);  // pixel type, linearity
    const std::uint32_t alongX = cursor.u32(), alongY = cursor.u32();
    if (name == "R" || name == "G" || name == "B" || name == "Y") {
      if (name == "Y")
        hasLuminance = true;
      else
        ++colours;
      isSubsampled |= alongX != 1 || alongY != 1;
    }
    if (++part.channels > kMaxChannels)
      throw SceneError(fmt::format("the EXR image has more than {} channels", kMaxChannels));
  }
  part.hasColour = (colours == 3 || hasLuminance) && !isSubsampled;
}

Part readPart(Cursor& cursor) {
  Part part;
  for (;;) {
    const std::string_view name = cursor.text();
    if (name.empty()) return part;
    const std::string_view type = cursor.text();
    const ByteSpan data = cursor.take(cursor.u32());
    Cursor value(data);
    if (name == "dataWindow" && type == "box2i") {
      const std::int64_t x0 = value.i32(), y0 = value.i32(), x1 = value.i32(), y1 = value.i32();
      part.width = x1 - x0 + 1;
      part.height = y1 - y0 + 1;
    } else if (name == "channels" && type == "chlist") {
      part.channels = 0;
      readChannels(data, part);
    } else if (name == "compression" && type == "compression" && !data.empty()) {
      part.compression = data[0];
    } else if (name == "tiles" && type == "tiledesc") {
      const std::uint64_t x = value.u32(), y = value.u32();
      part.tileWidth = x;
      part.tileHeight = y;
      part.tilePixels = x * y;
      part.tileMode = value.left() > 0 ? value.take(1)[0] & 0xfu : 0xfu;
      if (x == 0 || y == 0 || x > kMaxImageSide || y > kMaxImageSide)
        throw SceneError(fmt::format("corrupt EXR header: tiles of {} x {} pixels", x, y));
    }
  }
}

/// Lines of one chunk by the number of the compression; 0: not known.
std::int64_t linesOfChunk(unsigned compression) {
  // none, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A, DWAA, DWAB
  constexpr std::int64_t kLines[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
  return compression < std::size(kLines) ? kLines[compression] : 0;
}

/// Whether all chunks that the table names lie in the file, the last one whole.
bool hasAllChunks(const FilePieces& file, std::uint64_t table, std::uint64_t count, bool isTiled) {
  constexpr std::uint64_t kMostChunks = std::uint64_t{1} << 22;
  if (count == 0 || count > kMostChunks) return false;
  const Bytes offsets = file.read(table, static_cast<std::size_t>(8 * count));
  if (offsets.size() < 8 * count) return false;
  std::uint64_t last = 0;
  for (Cursor cursor(offsets); cursor.left() > 0;) {
    const std::uint64_t low = cursor.u32(), offset = low | std::uint64_t{cursor.u32()} << 32;
    if (offset < table + 8 * count) return false;
    last = std::max(last, offset);
  }
  // A chunk begins with its place, the line or four numbers of a tile, and its size.
  const std::size_t head = isTiled ? 20 : 8;
  const Bytes chunk = file.read(last, head);
  if (chunk.size() < head) return false;
  return Cursor(ByteSpan(chunk).last(4)).u32() <= file.size() - last - head;
}

}  // namespace

std::optional<Vec2i> sizeOfWholeExr(const FilePieces& file, ByteSpan head) {
  try {
    Cursor cursor(head);
    if (cursor.u32() != kMagic) return std::nullopt;
    const std::uint32_t version = cursor.u32();
    if ((version & 0xff) != 2 || (version & (kDeepFlag | kMultiPartFlag))) return std::nullopt;
    const Part part = readPart(cursor);
    if (!part.hasColour) return std::nullopt;
    checkImageSize(part.width, part.height, 4 * part.channels, file.size(), kMaxCompression);
    const bool isTiled = version & kTiledFlag;
    const std::int64_t lines = linesOfChunk(part.compression);
    if (lines == 0 || (isTiled && (part.tilePixels == 0 || part.tileMode != 0)))
      return std::nullopt;
    const auto w = static_cast<std::uint64_t>(part.width);
    const auto h = static_cast<std::uint64_t>(part.height);
    const auto pieces = [](std::uint64_t n, std::uint64_t size) { return (n + size - 1) / size; };
    const std::uint64_t count = isTiled ? pieces(w, part.tileWidth) * pieces(h, part.tileHeight)
                                        : pieces(h, static_cast<std::uint64_t>(lines));
    if (part.tilePixels * 4 * part.channels > kMaxTileBytes ||
        !hasAllChunks(file, cursor.position(), count, isTiled))
      return std::nullopt;
    return Vec2i(static_cast<int>(part.width), static_cast<int>(part.height));
  } catch (const SceneError&) {
    return std::nullopt;
  }
}

void checkExrHeader(ByteSpan bytes) {
  Cursor cursor(bytes);
  if (bytes.size() < 8 || cursor.u32() != kMagic) throw SceneError("not an OpenEXR file");
  const std::uint32_t version = cursor.u32();
  if ((version & 0xff) != 2)
    throw SceneError(fmt::format("OpenEXR version {} is not known", version & 0xff));
  if (version & kDeepFlag) throw SceneError("deep EXR images are not supported");

  do {
    const Part part = readPart(cursor);
    if (part.channels == 0) throw SceneError("corrupt EXR header: no channels");
    checkImageSize(part.width, part.height, 4 * part.channels, bytes.size(), kMaxCompression);
    if (part.tilePixels * 4 * part.channels > kMaxTileBytes)
      throw SceneError(fmt::format("EXR tiles of {} each are too large; the limit is {}",
                                   formatBytes(static_cast<double>(part.tilePixels) * 4 *
                                               static_cast<double>(part.channels)),
                                   formatBytes(static_cast<double>(kMaxTileBytes))));
  } while ((version & kMultiPartFlag) && !cursor.atEmptyText());
}

}  // namespace brume
