// SPDX-License-Identifier: Apache-2.0
#include "core/quadric.h"
#include "core/registry.h"

namespace brume {

namespace {

/// Open tube around the z axis; its normal points away from the axis.
///   u = phi / phimax, v from 0 at zmin to 1 at zmax.   Test: quadric_test.
class Cylinder final : public Quadric {
 public:
  struct Params {
    float radius = 1, zmin = -1, zmax = 1, phimax = 360;
    void visit(ParamVisitor& v) {
      v(radius, "radius", kPositive, Unit::Length, "radius");
      v(zmin, "zmin", kAnyFloat, Unit::Length, "lower end");
      v(zmax, "zmax", kAnyFloat, Unit::Length, "upper end");
      v(phimax, "phimax", {0.f, 360.f, true}, Unit::Degrees, "largest azimuth");
    }
  };

  Cylinder(Params params, const FactoryContext& context)
      : Quadric(context,
                {static_cast<double>(params.radius) * params.radius, 0, 0,
                 0.5 * (static_cast<double>(params.zmin) + params.zmax)},
                params.phimax),
        radius_(params.radius),
        zMin_(params.zmin),
        length_(static_cast<double>(params.zmax) - params.zmin) {
    if (!(length_ > 0)) throw SceneError(context.where, "cylinder: zmin must be smaller than zmax");
    setExtent({{-radius_, -radius_, zMin_},
               {radius_, radius_, zMin_ + length_},
               phiMax() * radius_ * length_},
              context.where);
  }

 private:
  bool exists(const Vec3d& p) const override {
    return p.z >= zMin_ && p.z <= zMin_ + length_ && phiExists(p.x, p.y);
  }
  Local local(const Vec3d& p) const override {
    const Polar at = polar(p, radius_);
    Local l;
    l.u = at.phi / phiMax();
    l.v = (p.z - zMin_) / length_;
    l.dpdu = Vec3d(-at.sinPhi, at.cosPhi, 0) * (phiMax() * radius_);
    l.dpdv = Vec3d(0, 0, length_);
    l.duu = Vec3d(at.cosPhi, at.sinPhi, 0) * (-phiMax() * phiMax() * radius_);
    l.n = Vec3d(at.cosPhi, at.sinPhi, 0);
    return l;
  }
  Vec3d sampleObject(Vec2 u) const override {
    const double phi = phiMax() * u.y;
    return {radius_ * std::cos(phi), radius_ * std::sin(phi), zMin_ + length_ * u.x};
  }

  double radius_, zMin_, length_;
};

const RegisterPlugin<Shape, Cylinder> kRegistration{"cylinder", Origin::PbrtV2,
                                                    "open tube around the z axis"};

}  // namespace

}  // namespace brume
