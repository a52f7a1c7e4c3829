// SPDX-License-Identifier: Apache-2.0
// Size checks that every image reader makes before it allocates.
#pragma once

#include <cstdint>

namespace brume {

/// Throws SceneError when width or height is not positive or above kMaxImageSide, when the decoded
/// pixels would exceed kMaxImageBytes, or when they exceed what `fileBytes` can hold at
/// `maxCompression` decoded bytes per byte of the file.
void checkImageSize(std::int64_t width, std::int64_t height, std::uint64_t bytesPerPixel,
                    std::uint64_t fileBytes, double maxCompression);

/// Longest side of an image.
inline constexpr std::int64_t kMaxImageSide = 1 << 18;

}  // namespace brume
