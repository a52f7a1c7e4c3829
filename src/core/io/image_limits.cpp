// SPDX-License-Identifier: Apache-2.0
#include "core/io/image_limits.h"

#include <fmt/format.h>

#include "core/io/file_bytes.h"
#include "core/io/image.h"

namespace brume {

void checkImageSize(std::int64_t width, std::int64_t height, std::uint64_t bytesPerPixel,
                    std::uint64_t fileBytes, double maxCompression) {
  if (width <= 0 || height <= 0)
    throw SceneError(fmt::format("corrupt file: the image is {} x {} pixels", width, height));
  const double needed =
      static_cast<double>(width) * static_cast<double>(height) * static_cast<double>(bytesPerPixel);
  if (width > kMaxImageSide || height > kMaxImageSide ||
      needed > static_cast<double>(kMaxImageBytes))
    throw SceneError(fmt::format(
        "the image is too large: {} x {} pixels need {}; the limits are {} pixels a side and {}",
        width, height, formatBytes(needed), kMaxImageSide,
        formatBytes(static_cast<double>(kMaxImageBytes))));
  if (needed > static_cast<double>(fileBytes) * maxCompression)
    throw SceneError(fmt::format(
        "corrupt or truncated file: the header promises {} x {} pixels ({}), the file "
        "has only {}",
        width, height, formatBytes(needed), formatBytes(static_cast<double>(fileBytes))));
}

}  // namespace brume
