// SPDX-License-Identifier: Apache-2.0
#include "core/quadric.h"
#include "core/registry.h"

namespace brume {

namespace {

/// Paraboloid x^2 + y^2 = k z with k = radius^2 / zmax, cut to zmin <= z <= zmax; its normal points
/// away from the axis.
///   u = phi / phimax, v from 0 at zmin to 1 at zmax
/// Area up to z: phimax 2/(3k) ((k z + k^2/4)^1.5 - (k^2/4)^1.5).   Test: quadric_test.
class Paraboloid final : public Quadric {
 public:
  struct Params {
    float radius = 1, zmin = 0, zmax = 1, phimax = 360;
    void visit(ParamVisitor& v) {
      v(radius, "radius", kPositive, Unit::Length, "radius at zmax");
      v(zmin, "zmin", kNonNegative, Unit::Length, "lower cut; the apex is at 0");
      v(zmax, "zmax", kPositive, Unit::Length, "upper cut");
      v(phimax, "phimax", {0.f, 360.f, true}, Unit::Degrees, "largest azimuth");
    }
  };

  Paraboloid(Params params, const FactoryContext& context)
      : Quadric(context, {0, slopeOf(params), 0, 0.5 * params.zmax}, params.phimax),
        k_(slopeOf(params)),
        radius_(params.radius),
        zMin_(params.zmin),
        zMax_(params.zmax) {
    if (!(zMin_ < zMax_))
      throw SceneError(context.where, "paraboloid: zmin must be smaller than zmax");
    setExtent({{-radius_, -radius_, zMin_},
               {radius_, radius_, zMax_},
               phiMax() * 2 / (3 * k_) * (areaTerm(zMax_) - areaTerm(zMin_))},
              context.where);
  }

 private:
  static double slopeOf(const Params& params) {
    return static_cast<double>(params.radius) * params.radius / params.zmax;
  }
  double areaTerm(double z) const { return std::pow(k_ * z + 0.25 * k_ * k_, 1.5); }
  bool exists(const Vec3d& p) const override {
    return p.z >= zMin_ && p.z <= zMax_ && phiExists(p.x, p.y);
  }
  Local local(const Vec3d& p) const override {
    const Polar at = polar(p, 1e-5 * radius_);
    const double length = zMax_ - zMin_, r = at.radius;
    const Vec3d outward(at.cosPhi, at.sinPhi, 0), around(-at.sinPhi, at.cosPhi, 0);
    Local l;
    l.u = at.phi / phiMax();
    l.v = (p.z - zMin_) / length;
    l.dpdu = around * (phiMax() * r);
    l.dpdv = (outward * (k_ / (2 * r)) + Vec3d(0, 0, 1)) * length;
    l.duu = outward * (-phiMax() * phiMax() * r);
    l.duv = around * (length * phiMax() * k_ / (2 * r));
    l.dvv = outward * (-length * length * k_ * k_ / (4 * r * r * r));
    l.n = normalize(Vec3d(2 * p.x, 2 * p.y, -k_));
    return l;
  }
  Vec3d sampleObject(Vec2 u) const override {
    const double low = areaTerm(zMin_), term = low + (areaTerm(zMax_) - low) * u.x;
    const double z = std::clamp((std::cbrt(term * term) - 0.25 * k_ * k_) / k_, zMin_, zMax_);
    const double r = std::sqrt(k_ * z), phi = phiMax() * u.y;
    return {r * std::cos(phi), r * std::sin(phi), z};
  }

  double k_, radius_, zMin_, zMax_;
};

const RegisterPlugin<Shape, Paraboloid> kRegistration{"paraboloid", Origin::PbrtV2,
                                                      "paraboloid around the z axis"};

}  // namespace

}  // namespace brume
