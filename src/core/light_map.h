// SPDX-License-Identifier: Apache-2.0
// Images that lights emit: reading, bilinear lookup, and importance sampling of lat-long maps.
#pragma once

#include "core/io/image.h"
#include "core/light.h"
#include "core/sampling.h"

namespace brume {

/// Reads the map of a light. Rows are in PBRT-v2's order: an EXR's first row is t = 0, a TGA's and
/// a PFM's last one is. Negative and NaN values become 0, infinite ones the largest half float
/// (65504), with a warning. Throws SceneError at the parameter when the file cannot be read.
RgbImage readLightMap(const Filename& file, Log& log);

/// Bilinear interpolation between pixel centres, (s, t) in [0, 1]^2, t from the first row down; the
/// border pixels are extended.
Rgb bilinear(const RgbImage& image, Vec2 st);

/// A unit direction to lat-long coordinates with the pole +z: s = phi / 2 pi from +x towards +y,
/// t = theta / pi.
Vec2 latLongFromDirection(const Vec3& w);
Vec3 directionFromLatLong(Vec2 st);

/// A map over all directions, bilinear, periodic in s and extended at the poles.
class LatLongMap {
 public:
  explicit LatLongMap(RgbImage image);

  Rgb at(Vec2 st) const;
  Rgb at(const Vec3& direction) const { return at(latLongFromDirection(direction)); }
  /// Integral over the sphere [value sr].
  Rgb integral() const { return integral_; }
  /// Largest weight (lightWeight) of any pixel.
  float maxWeight() const { return maxWeight_; }
  /// The mean of the interpolated map over each pixel's square times the pixel's share of solid
  /// angle: positive wherever the map is, so sampling by it misses no light. `tint` multiplies the
  /// map.
  Distribution2D makeDistribution(const Rgb& tint) const;

 private:
  Rgb meanOver(int x, int y) const;
  /// Solid angle of the pixels of row y, over 2 pi: cos theta_y - cos theta_{y+1}.
  double rowShare(int y) const;

  RgbImage image_;
  Rgb integral_;
  float maxWeight_ = 0;
};

}  // namespace brume
