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
constexpr std::uint32_t kDeepFlag = 0x800, kMultiPartFlag = 0x1000;
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
  bool atEmptyText() const { return left() > 0 && bytes_[position_] == 0; }

 private:
  [[noreturn]] static void truncated() { throw SceneError("truncated EXR header"); }

  ByteSpan bytes_;
  std::size_t position_ = 0;
};

struct Part {
  std::int64_t width = 0, height = 0;
  std::size_t channels = 0;
  std::uint64_t tilePixels = 0;
};

std::size_t countChannels(ByteSpan list) {
  Cursor cursor(list);
  std::size_t count = 0;
  while (!cursor.text().empty()) {
    cursor.take(16);  // pixel type, linearity, sampling rates
    if (++count > kMaxChannels)
      throw SceneError(fmt::format("the EXR image has more than {} channels", kMaxChannels));
  }
  return count;
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
      part.channels = countChannels(data);
    } else if (name == "tiles" && type == "tiledesc") {
      const std::uint64_t x = value.u32(), y = value.u32();
      part.tilePixels = x * y;
      if (x == 0 || y == 0 || x > kMaxImageSide || y > kMaxImageSide)
        throw SceneError(fmt::format("corrupt EXR header: tiles of {} x {} pixels", x, y));
    }
  }
}

}  // namespace

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
