// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "core/srgb.h"
#include "tools/image_metrics.h"

namespace brume {
namespace {

/// Eight even steps of the colour map magma, sRGB code values.
constexpr std::array<Rgb, 8> kMagma{{{0x00, 0x00, 0x04},
                                     {0x22, 0x11, 0x50},
                                     {0x5f, 0x18, 0x7f},
                                     {0x98, 0x2d, 0x80},
                                     {0xd3, 0x43, 0x6e},
                                     {0xf8, 0x76, 0x5c},
                                     {0xfe, 0xbb, 0x81},
                                     {0xfc, 0xfd, 0xbf}}};
constexpr Rgb kNanColor{0, 1, 0};

Rgb magma(float value) {
  constexpr int kSteps = static_cast<int>(kMagma.size()) - 1;
  const float x = std::clamp(value, 0.f, 1.f) * kSteps;
  const int step = std::min(static_cast<int>(x), kSteps - 1);
  const auto i = static_cast<std::size_t>(step);
  const Rgb code = lerp(kMagma[i], kMagma[i + 1], x - static_cast<float>(step)) / 255.f;
  return {decodeSrgb(code.r), decodeSrgb(code.g), decodeSrgb(code.b)};
}

}  // namespace

RgbImage heatmap(const ScalarImage& image) {
  RgbImage result(image.width, image.height);
  std::transform(image.values.begin(), image.values.end(), result.pixels.begin(),
                 [](float v) { return std::isnan(v) ? kNanColor : magma(v); });
  return result;
}

}  // namespace brume
