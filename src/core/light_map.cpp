// SPDX-License-Identifier: Apache-2.0
#include "core/light_map.h"

#include <fmt/format.h>

#include "core/log.h"

namespace brume {

namespace {

/// Position x (in pixels) between the centres of two pixels.
struct Between {
  int lower;
  float fraction;
};
Between betweenCentres(float x) {
  const float shifted = x - 0.5f, lower = std::floor(shifted);
  return {static_cast<int>(lower), shifted - lower};
}

template <class Pixel>
Rgb interpolate(const Between& x, const Between& y, const Pixel& pixel) {
  const Rgb upper =
      pixel(x.lower, y.lower) * (1 - x.fraction) + pixel(x.lower + 1, y.lower) * x.fraction;
  const Rgb lower =
      pixel(x.lower, y.lower + 1) * (1 - x.fraction) + pixel(x.lower + 1, y.lower + 1) * x.fraction;
  return upper * (1 - y.fraction) + lower * y.fraction;
}

bool hasRowsFromTheBottom(const std::string& path) {
  const auto ends = [&path](const char* extension) { return path.ends_with(extension); };
  return ends(".tga") || ends(".TGA") || ends(".pfm") || ends(".PFM");
}

}  // namespace

RgbImage readLightMap(const Filename& file, Log& log) {
  RgbImage image;
  try {
    image = readImage(file.path);
  } catch (const SceneError& error) {
    throw SceneError(file.where, error.what());
  }
  if (image.pixels.empty())
    throw SceneError(file.where, fmt::format("the image '{}' has no pixels", file.written));
  if (hasRowsFromTheBottom(file.path))
    for (int y = 0; y < image.height / 2; ++y)
      std::swap_ranges(&image.at(0, y), &image.at(0, y) + image.width,
                       &image.at(0, image.height - 1 - y));

  std::size_t changed = 0;
  for (Rgb& pixel : image.pixels)
    for (int c = 0; c < 3; ++c) {
      const float v = pixel[c];
      if (v >= 0 && std::isfinite(v)) continue;
      pixel[c] = v > 0 ? kLargestHalf : 0;
      ++changed;
    }
  if (changed > 0)
    log.warning(file.where, fmt::format("'{}' has {} negative, infinite or NaN values; they are "
                                        "taken as 0, 65504 and 0",
                                        file.written, changed));
  return image;
}

Rgb bilinear(const RgbImage& image, Vec2 st) {
  return interpolate(betweenCentres(st.x * static_cast<float>(image.width)),
                     betweenCentres(st.y * static_cast<float>(image.height)), [&](int x, int y) {
                       return image.at(std::clamp(x, 0, image.width - 1),
                                       std::clamp(y, 0, image.height - 1));
                     });
}

Vec2 latLongFromDirection(const Vec3& w) {
  const float phi = std::atan2(w.y, w.x), theta = std::atan2(std::hypot(w.x, w.y), w.z);
  const float s = phi * (0.5f * kInvPi);
  // Also for NaN: the result is an index into the map.
  const auto unit = [](float v) { return v >= 0 ? std::min(v, kOneMinusEpsilon) : 0.f; };
  return {unit(s < 0 ? s + 1.f : s), unit(theta * kInvPi)};
}

LatLongMap::LatLongMap(RgbImage image) : image_(std::move(image)) {
  double sum[3] = {0, 0, 0};
  for (int y = 0; y < image_.height; ++y) {
    const double solidAngle = rowShare(y, image_.height) * 2 * M_PI / image_.width;
    for (int x = 0; x < image_.width; ++x) {
      const Rgb mean = meanOver(x, y);
      for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(mean[c]) * solidAngle;
      maxWeight_ = std::max(maxWeight_, lightWeight(image_.at(x, y)));
    }
  }
  integral_ = {static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
}

Rgb LatLongMap::at(Vec2 st) const {
  const auto wrap = [this](int x) {
    return x < 0 ? x + image_.width : x >= image_.width ? x - image_.width : x;
  };
  return interpolate(betweenCentres(st.x * static_cast<float>(image_.width)),
                     betweenCentres(st.y * static_cast<float>(image_.height)), [&](int x, int y) {
                       return image_.at(wrap(x), std::clamp(y, 0, image_.height - 1));
                     });
}

Rgb LatLongMap::meanOver(int x, int y) const {
  // The interpolant's mean over a pixel weighs it and its neighbours 1/8, 6/8, 1/8 along each axis.
  const int w = image_.width, h = image_.height;
  const int left = x > 0 ? x - 1 : w - 1, right = x + 1 < w ? x + 1 : 0;
  const auto row = [&](int r) {
    return (image_.at(left, r) + image_.at(right, r)) * 0.125f + image_.at(x, r) * 0.75f;
  };
  return (row(std::max(0, y - 1)) + row(std::min(h - 1, y + 1))) * 0.125f + row(y) * 0.75f;
}

double LatLongMap::rowShare(int y, int height) {
  const double step = M_PI / height;
  return 2 * std::sin((y + 0.5) * step) * std::sin(0.5 * step);
}

LatLongDistribution::LatLongDistribution(const LatLongMap& map, const Rgb& tint)
    : height_(map.image().height) {
  const int width = map.image().width;
  std::vector<float> weights(map.image().pixels.size());
  std::size_t i = 0;
  for (int y = 0; y < height_; ++y) {
    const float share = static_cast<float>(LatLongMap::rowShare(y, height_));
    for (int x = 0; x < width; ++x) weights[i++] = lightWeight(map.meanOver(x, y) * tint) * share;
  }
  pixels_ = {weights, static_cast<std::size_t>(width), static_cast<std::size_t>(height_)};
}

float LatLongDistribution::perSolidAngle(float pdf, int row) const {
  // A pixel has 1 / (width height) of the square and 2 pi share / width of the sphere.
  return pdf / static_cast<float>(2 * M_PI * height_ * LatLongMap::rowShare(row, height_));
}

LatLongDistribution::Sample LatLongDistribution::sample(Vec2 u) const {
  const Distribution2D::Sample onSquare = pixels_.sample(u);
  // Inside its row the point moves so that cos theta is uniform, not theta.
  const double y = static_cast<double>(onSquare.p.y) * height_;
  const int row = std::min(static_cast<int>(y), height_ - 1);
  const double upper = row * M_PI / height_, share = LatLongMap::rowShare(row, height_);
  // 1 - cos theta, exact near both poles.
  const double omc = 2 * sqr(std::sin(0.5 * upper)) + (y - row) * share;
  const double theta = 2 * std::asin(std::sqrt(std::min(1.0, 0.5 * omc)));
  const double phi = 2 * M_PI * static_cast<double>(onSquare.p.x), sinTheta = std::sin(theta);
  Sample sample;
  sample.st = {onSquare.p.x, static_cast<float>(theta / M_PI)};
  sample.w = Vec3(Vec3d(sinTheta * std::cos(phi), sinTheta * std::sin(phi), std::cos(theta)));
  sample.pdf = perSolidAngle(onSquare.pdf, row);
  return sample;
}

float LatLongDistribution::pdf(const Vec3& w) const {
  const Vec2 st = latLongFromDirection(w);
  const int row = std::min(static_cast<int>(st.y * static_cast<float>(height_)), height_ - 1);
  return perSolidAngle(pixels_.pdf(st), row);
}

}  // namespace brume
