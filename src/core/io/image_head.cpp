// SPDX-License-Identifier: Apache-2.0
#include "core/io/image_head.h"

#include "core/error.h"
#include "core/io/exr_header.h"
#include "core/io/file_bytes.h"
#include "core/io/image.h"
#include "core/io/image_format.h"
#include "core/io/image_integrity.h"
#include "core/io/image_limits.h"
#include "core/io/pfm_file.h"

namespace brume {
namespace {

constexpr std::size_t kHeadBytes = std::size_t{1} << 16;
constexpr std::uint64_t kMaxStbBytes = std::uint64_t{1} << 30;

/// PNG, JPEG, TGA and HDR. Throws SceneError for what is wrong.
std::optional<Vec2i> sizeOfWholeStbImage(const FilePieces& file, ByteSpan head) {
  const StbFormat format = detectStbFormat(head);
  const std::optional<Vec2i> size = sizeInHead(format, head);
  if (!size || file.size() > kMaxStbBytes) return std::nullopt;
  checkImageSize(size->x, size->y, sizeof(Rgb), file.size(), maxCompression(format));
  const std::uint64_t tailAt = file.size() - std::min<std::uint64_t>(file.size(), kTailBytes);
  if (hasProperEnd(format, head, file.read(tailAt, kTailBytes), file.size())) return size;
  const Bytes all = file.read(0, static_cast<std::size_t>(file.size()));
  checkIntegrity(format, all);
  return size;
}

}  // namespace

std::optional<Vec2i> sizeOfWholeImage(const std::string& path) {
  const ImageExtension* extension = findImageExtension(path);
  const std::optional<FilePieces> file = FilePieces::open(path);
  if (!extension || !file || file->size() > kMaxImageBytes) return std::nullopt;
  const Bytes head = file->read(0, kHeadBytes);
  try {
    switch (extension->format) {
      case ImageFormat::Exr:
        return sizeOfWholeExr(*file, head);
      case ImageFormat::Pfm:
        return sizeOfWholePfm(head, file->size());
      case ImageFormat::Png:
      case ImageFormat::Tga:
      case ImageFormat::Jpeg:
      case ImageFormat::Hdr:
        return sizeOfWholeStbImage(*file, head);
    }
  } catch (const SceneError&) {
  } catch (const std::bad_alloc&) {
  }
  return std::nullopt;
}

}  // namespace brume
