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

/// A direction of any length to lat-long coordinates in [0, 1)^2 with the pole +z: s = phi / 2 pi
/// from +x towards +y, t = theta / pi.
Vec2 latLongFromDirection(const Vec3& w);

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
  const RgbImage& image() const { return image_; }
  /// Mean of the interpolated map over the square of a pixel.
  Rgb meanOver(int x, int y) const;
  /// Solid angle of the pixels of row y, over 2 pi: cos theta_y - cos theta_{y+1}.
  static double rowShare(int y, int height);

 private:
  RgbImage image_;
  Rgb integral_;
  float maxWeight_ = 0;
};

/// Samples directions in proportion to a map: a pixel by the weight of the map's mean over it times
/// its solid angle, then uniformly in solid angle inside the pixel. The density is positive
/// wherever the interpolated map is, so no light is missed, and has no pole.
class LatLongDistribution {
 public:
  LatLongDistribution() = default;
  /// `tint` multiplies the map.
  LatLongDistribution(const LatLongMap& map, const Rgb& tint);

  struct Sample {
    Vec2 st{0};
    Vec3 w{0, 0, 1};  ///< unit
    float pdf = 0;    ///< per solid angle
  };
  Sample sample(Vec2 u) const;
  float pdf(const Vec3& w) const;

 private:
  float perSolidAngle(float pdf, int row) const;

  Distribution2D pixels_;
  int height_ = 1;
};

}  // namespace brume
