// SPDX-License-Identifier: Apache-2.0
#include "core/material.h"

namespace brume {

void Material::evaluate(const SurfaceInteraction& at, Bsdf& bsdf) const {
  if (const FloatSlot* displacement = bumpMap()) {
    const BumpedFrame bumped = bumpFrame(at, *displacement);
    bsdf.reset(bumped.ns, bumped.dpdu, at.n);
  } else {
    bsdf.reset(at.ns, at.shading.dpdu, at.n);
  }
  addLobes(at, bsdf);
}

namespace {

/// Half of the footprint's extent in one surface parameter.
float bumpStep(float ddx, float ddy) {
  constexpr float kWithoutFootprint = .01f;
  const float step = .5f * (std::abs(ddx) + std::abs(ddy));
  return step > 0.f && std::isfinite(step) ? step : kWithoutFootprint;
}

}  // namespace

BumpedFrame bumpFrame(const SurfaceInteraction& at, const FloatSlot& displacement) {
  // The displacement here and one step along each tangent.
  const SurfaceDerivatives& s = at.shading;
  const float du = bumpStep(at.texture.dudx, at.texture.dudy);
  const float dv = bumpStep(at.texture.dvdx, at.texture.dvdy);
  TextureContext atU = at.texture, atV = at.texture;
  atU.p += du * s.dpdu;
  atU.uv.x += du;
  atV.p += dv * s.dpdv;
  atV.uv.y += dv;
  const float d = displacement.evaluate(at.texture);
  const float dddu = (displacement.evaluate(atU) - d) / du;
  const float dddv = (displacement.evaluate(atV) - d) / dv;

  // The tangents of p + d n; the normal is turned to the side of the geometric one.
  const Vec3 dpdu = s.dpdu + dddu * at.ns + d * s.dndu;
  const Vec3 dpdv = s.dpdv + dddv * at.ns + d * s.dndv;
  const std::optional<Vec3> ns = tryNormalize(cross(dpdu, dpdv));
  if (!ns) return {faceForward(at.ns, at.n), s.dpdu};
  return {faceForward(*ns, at.n), dpdu};
}

}  // namespace brume
