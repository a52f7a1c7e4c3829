// SPDX-License-Identifier: Apache-2.0
#include "core/quadric.h"
#include "core/registry.h"

namespace brume {

namespace {

/// Open cone around the z axis, its base of radius `radius` at z = 0, its apex at z = height; its
/// normal points away from the axis.
///   u = phi / phimax, v = z / height.   Test: quadric_test.
class Cone final : public Quadric {
 public:
  struct Params {
    float radius = 1, height = 1, phimax = 360;
    void visit(ParamVisitor& v) {
      v(radius, "radius", kPositive, Unit::Length, "radius of the base");
      v(height, "height", kPositive, Unit::Length, "distance of the apex from the base");
      v(phimax, "phimax", {0.f, 360.f, true}, Unit::Degrees, "largest azimuth");
    }
  };

  Cone(Params params, const FactoryContext& context)
      : Quadric(context, profileOf(params), params.phimax),
        radius_(params.radius),
        height_(params.height) {
    setExtent({{-radius_, -radius_, 0},
               {radius_, radius_, height_},
               0.5 * phiMax() * radius_ * std::sqrt(radius_ * radius_ + height_ * height_)},
              context.where);
  }

 private:
  static Profile profileOf(const Params& params) {
    const double r = params.radius, h = params.height, k = r / h;
    return {r * r, -2 * r * k, k * k, 0.5 * h};
  }
  bool exists(const Vec3d& p) const override {
    return p.z >= 0 && p.z <= height_ && phiExists(p.x, p.y);
  }
  Local local(const Vec3d& p) const override {
    const Polar at = polar(p, 1e-5 * radius_);
    Local l;
    l.u = at.phi / phiMax();
    l.v = p.z / height_;
    l.dpdu = Vec3d(-at.sinPhi, at.cosPhi, 0) * (phiMax() * at.radius);
    l.dpdv = Vec3d(-radius_ * at.cosPhi, -radius_ * at.sinPhi, height_);
    l.duu = Vec3d(at.cosPhi, at.sinPhi, 0) * (-phiMax() * phiMax() * at.radius);
    l.duv = Vec3d(at.sinPhi, -at.cosPhi, 0) * (phiMax() * radius_);
    l.n = normalize(Vec3d(height_ * at.cosPhi, height_ * at.sinPhi, radius_));
    return l;
  }
  Vec3d sampleObject(Vec2 u) const override {
    const double part = std::sqrt(1 - static_cast<double>(u.x)), r = radius_ * part;
    const double phi = phiMax() * u.y;
    return {r * std::cos(phi), r * std::sin(phi), height_ * (1 - part)};
  }

  double radius_, height_;
};

const RegisterPlugin<Shape, Cone> kRegistration{"cone", Origin::PbrtV2,
                                                "open cone around the z axis"};

}  // namespace

}  // namespace brume
