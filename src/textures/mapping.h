// SPDX-License-Identifier: Apache-2.0
// From a point on a surface to texture coordinates, as the textures of PBRT-v2 share it.
#pragma once

#include "core/params.h"

namespace brume {

/// Texture coordinates and their change to the next samples in raster x and y.
struct TexturePoint2 {
  Vec2 st{0}, dstdx{0}, dstdy{0};
};

/// The 2-D mappings:
///   uv           s = uscale u + udelta, t = vscale v + vdelta
///   spherical    s = theta / pi, t = phi / 2 pi            (theta from +z, phi from +x)
///   cylindrical  s = (pi + atan2(y, x)) / 2 pi, t = z / |p|
///   planar       s = p . v1 + udelta, t = p . v2 + vdelta
/// Spherical and cylindrical take p in texture space (inverse CTM), planar in scene space.
/// Quirks of PBRT-v2 that images were authored with: the cylinder's height is that of the
/// normalised position; derivatives of the two are differences over 0.1 and 0.01 of the step to the
/// next sample, so that a line of samples along the seam gets a wide footprint.
class Mapping2D {
 public:
  enum class Kind { Uv, Spherical, Cylindrical, Planar };
  struct Params {
    Kind kind = Kind::Uv;
    float uscale = 1, vscale = 1, udelta = 0, vdelta = 0;
    Vec3 v1{1, 0, 0}, v2{0, 1, 0};
    void visit(ParamVisitor& v);
  };

  Mapping2D(const Params& params, const TextureFactoryContext& context);
  TexturePoint2 operator()(const TextureContext& at) const;

 private:
  TexturePoint2 uv(const TextureContext& at) const;
  TexturePoint2 planar(const TextureContext& at) const;
  template <class Project>
  TexturePoint2 projected(const TextureContext& at, float delta, const Project& project) const;

  Params params_;
  Transform sceneToTexture_;
};

/// A position in a solid texture and its change to the next samples.
struct TexturePoint3 {
  Vec3 p{0}, dpdx{0}, dpdy{0};
};

/// Positions of solid textures: multiplied by the CTM itself, not its inverse, as PBRT-v2 does:
/// Scale 2 doubles the frequency.
class Mapping3D {
 public:
  explicit Mapping3D(const TextureFactoryContext& context) : map_(context.textureToScene) {}
  TexturePoint3 operator()(const TextureContext& at) const {
    return {map_.point(at.p), map_.vector(at.dpdx), map_.vector(at.dpdy)};
  }

 private:
  Transform map_;
};

/// `octaves` and `roughness` of the noise textures. The bounds keep sums finite.
struct OctaveParams {
  int octaves = 8;
  float roughness = .5f;
  void visit(ParamVisitor& v);
};

}  // namespace brume
