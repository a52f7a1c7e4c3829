// SPDX-License-Identifier: Apache-2.0
#include "textures/mapping.h"

#include <fmt/format.h>

#include "core/log.h"

namespace brume {
namespace {

/// Unit vector from the origin of texture space; the origin itself counts as +z.
Vec3 direction(const Vec3& p) { return tryNormalize(p).value_or(Vec3(0, 0, 1)); }

Vec2 onSphere(const Vec3& p) {
  const Vec3 d = direction(p);
  const float phi = std::atan2(d.y, d.x);
  return {safeAcos(d.z) * kInvPi, (phi < 0 ? phi + 2 * kPi : phi) * (.5f * kInvPi)};
}

Vec2 onCylinder(const Vec3& p) {
  const Vec3 d = direction(p);
  return {(kPi + std::atan2(d.y, d.x)) * (.5f * kInvPi), d.z};
}

/// PBRT-v2's correction of dt for steps across t = 0.
float acrossSeam(float dt) { return dt > .5f ? 1 - dt : dt < -.5f ? -(dt + 1) : dt; }

/// Names of given (not default) parameters that the mapping does not use.
std::string unusedParams(const Mapping2D::Params& p) {
  using Kind = Mapping2D::Kind;
  std::vector<std::string> names;
  const Mapping2D::Params standard;
  const bool usesDelta = p.kind == Kind::Uv || p.kind == Kind::Planar;
  if (p.kind != Kind::Uv && (p.uscale != 1 || p.vscale != 1)) names.push_back("uscale, vscale");
  if (!usesDelta && (p.udelta != 0 || p.vdelta != 0)) names.push_back("udelta, vdelta");
  if (p.kind != Kind::Planar && (p.v1 != standard.v1 || p.v2 != standard.v2))
    names.push_back("v1, v2");
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

void Mapping2D::Params::visit(ParamVisitor& v) {
  v(kind, "mapping",
    {{"uv", Kind::Uv},
     {"spherical", Kind::Spherical},
     {"cylindrical", Kind::Cylindrical},
     {"planar", Kind::Planar}},
    "from surface to texture coordinates s, t");
  v(uscale, "uscale", kAnyFloat, Unit::None, "uv: s = uscale u + udelta");
  v(vscale, "vscale", kAnyFloat, Unit::None, "uv: t = vscale v + vdelta");
  v(udelta, "udelta", kAnyFloat, Unit::None, "uv and planar: added to s");
  v(vdelta, "vdelta", kAnyFloat, Unit::None, "uv and planar: added to t");
  v.vector(v1, "v1", Unit::InverseLength, "planar: s = p . v1 + udelta, p in scene space");
  v.vector(v2, "v2", Unit::InverseLength, "planar: t = p . v2 + vdelta, p in scene space");
}

Mapping2D::Mapping2D(const Params& params, const TextureFactoryContext& context)
    : params_(params), sceneToTexture_(context.textureToScene.inverse()) {
  if (const std::string unused = unusedParams(params); !unused.empty() && context.log)
    context.log->warning(context.where, fmt::format("{} have no effect with this mapping", unused));
}

TexturePoint2 Mapping2D::uv(const TextureContext& at) const {
  const Vec2 scale(params_.uscale, params_.vscale);
  return {scale * at.uv + Vec2(params_.udelta, params_.vdelta), scale * Vec2(at.dudx, at.dvdx),
          scale * Vec2(at.dudy, at.dvdy)};
}

TexturePoint2 Mapping2D::planar(const TextureContext& at) const {
  const auto project = [&](const Vec3& v) { return Vec2(dot(v, params_.v1), dot(v, params_.v2)); };
  return {project(at.p) + Vec2(params_.udelta, params_.vdelta), project(at.dpdx), project(at.dpdy)};
}

template <class Project>
TexturePoint2 Mapping2D::projected(const TextureContext& at, float delta,
                                   const Project& project) const {
  const Vec2 st = project(sceneToTexture_.point(at.p));
  const auto change = [&](const Vec3& dp) {
    Vec2 d = (project(sceneToTexture_.point(at.p + delta * dp)) - st) / delta;
    d.y = acrossSeam(d.y);
    return d;
  };
  return {st, change(at.dpdx), change(at.dpdy)};
}

TexturePoint2 Mapping2D::operator()(const TextureContext& at) const {
  switch (params_.kind) {
    case Kind::Spherical:
      return projected(at, .1f, onSphere);
    case Kind::Cylindrical:
      return projected(at, .01f, onCylinder);
    case Kind::Planar:
      return planar(at);
    case Kind::Uv:
      break;
  }
  return uv(at);
}

void OctaveParams::visit(ParamVisitor& v) {
  v(octaves, "octaves", Range<int>{0, 32}, Unit::None, "number of octaves, each 1.99 times finer");
  v(roughness, "roughness", Range<float>{-10.f, 10.f}, Unit::None,
    "amplitude of each octave against the one before");
}

}  // namespace brume
