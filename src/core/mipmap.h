// SPDX-License-Identifier: Apache-2.0
// Image pyramid with filtered lookups, for textures and for lights with maps.
#pragma once

#include <vector>

#include "core/math.h"
#include "core/rgb.h"

namespace brume {

/// What lies outside [0,1]^2.
enum class WrapMode { Repeat, Black, Clamp };

struct MipMapSettings {
  WrapMode wrap = WrapMode::Repeat;
  bool trilinear = false;     ///< isotropic filtering instead of EWA
  float maxAnisotropy = 8.f;  ///< longest allowed ratio of the axes of the EWA filter
};

/// A pyramid of box-filtered images over the texture square [0,1]^2: level 0 is the image, brought
/// to the next powers of two by a Lanczos filter; every further level halves both sides; the last
/// is one texel. Texel (s,t) of a level of w x h texels lies at ((s+.5)/w, (t+.5)/h); row t = 0 is
/// the first row of the image that was given. T is float or Rgb.
template <class T>
class MipMap {
 public:
  /// `texels` row-major, width x height of them. Throws SceneError when the pyramid would be too
  /// large for memory.
  MipMap(int width, int height, std::vector<T> texels, const MipMapSettings& settings);

  /// Memory of a pyramid over an image of this size; whether it is below the limit.
  static double bytes(Vec2i size);
  static bool fits(Vec2i size);

  int width() const { return levels_[0].width; }
  int height() const { return levels_[0].height; }
  int levels() const { return static_cast<int>(levels_.size()); }
  /// With the wrap mode applied.
  T texel(int level, int s, int t) const;

  /// Trilinear lookup at st with a filter of the given width (1: the whole square).
  T lookup(Vec2 st, float width = 0.f) const;
  /// Elliptically weighted average over the footprint spanned by dst0 and dst1 (changes of st to
  /// the next samples): Gaussian exp(-2 r^2) - exp(-2) over the ellipse, its longer axis at most
  /// maxAnisotropy times the shorter. A footprint without area is looked up bilinearly on level 0.
  /// With `trilinear` set, lookup(st, 2 max |component|). Source: Heckbert 1989, Fundamentals of
  /// Texture Mapping and Image Warping; choice of levels as in PBRT-v2.
  T lookup(Vec2 st, Vec2 dst0, Vec2 dst1) const;

 private:
  struct Level {
    int width, height;
    std::vector<T> texels;
    const T* row(int t) const {
      return texels.data() + static_cast<std::size_t>(t) * static_cast<std::size_t>(width);
    }
  };

  T bilinear(const Level& level, Vec2 st) const;
  T ewa(const Level& level, Vec2 st, Vec2 dst0, Vec2 dst1) const;
  class RowWeights;
  /// Sum of weight * texel over texels s0..s1 of row t, wrapped.
  void accumulateRow(const Level& level, int t, int s0, int s1, RowWeights weights, T& sum,
                     float& sumWeights) const;
  T wrapped(const Level& level, int s, int t) const;
  Vec2 wrapPoint(Vec2 st) const;

  MipMapSettings settings_;
  std::vector<Level> levels_;
};

extern template class MipMap<float>;
extern template class MipMap<Rgb>;

}  // namespace brume
