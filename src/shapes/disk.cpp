// SPDX-License-Identifier: Apache-2.0
#include "core/quadric.h"
#include "core/registry.h"
#include "core/sampling.h"

namespace brume {

namespace {

/// Disk at z = height, or a ring or sector of one; its normal is +z.
///   u = phi / phimax, v = 0 at the rim to 1 at the inner edge
/// As a light it shines to +z. (PBRT-v2's last version has the sign of dpdv reversed: its disks
/// show on -z and light +z.) Test: quadric_test.
class Disk final : public Quadric {
 public:
  struct Params {
    float height = 0, radius = 1, innerradius = 0, phimax = 360;
    void visit(ParamVisitor& v) {
      v(height, "height", kAnyFloat, Unit::Length, "z of the disk");
      v(radius, "radius", kPositive, Unit::Length, "outer radius");
      v(innerradius, "innerradius", kNonNegative, Unit::Length, "radius of the hole");
      v(phimax, "phimax", {0.f, 360.f, true}, Unit::Degrees, "largest azimuth");
    }
  };

  Disk(Params params, const FactoryContext& context)
      : Quadric(context, {0, 0, 0, params.height}, params.phimax),
        height_(params.height),
        radius_(params.radius),
        innerRadius_(params.innerradius) {
    if (!(innerRadius_ < radius_))
      throw SceneError(context.where, "disk: innerradius must be smaller than radius");
    setExtent({{-radius_, -radius_, height_},
               {radius_, radius_, height_},
               0.5 * phiMax() * (radius_ * radius_ - innerRadius_ * innerRadius_),
               normal({})},
              context.where);
  }

  DirectionCone normals() const override { return DirectionCone::around(sampleArea(Vec2(0.5f)).n); }

 private:
  Roots roots(const Vec3d& o, const Vec3d& d) const override {
    return {(height_ - o.z) / d.z, std::numeric_limits<double>::infinity()};
  }
  Vec3d project(const Vec3d& p) const override { return {p.x, p.y, height_}; }
  bool exists(const Vec3d& p) const override {
    const double r2 = p.x * p.x + p.y * p.y;
    return r2 <= radius_ * radius_ && r2 >= innerRadius_ * innerRadius_ && phiExists(p.x, p.y);
  }
  Local local(const Vec3d& p) const override {
    const Polar at = polar(p, 1e-5 * radius_);
    const double width = radius_ - innerRadius_;
    Local l;
    l.u = at.phi / phiMax();
    l.v = 1 - (std::sqrt(p.x * p.x + p.y * p.y) - innerRadius_) / width;
    l.dpdu = Vec3d(-at.sinPhi, at.cosPhi, 0) * (phiMax() * at.radius);
    l.dpdv = Vec3d(at.cosPhi, at.sinPhi, 0) * -width;
    l.n = normal(p);
    return l;  // a plane: the second derivatives have no part along n
  }
  Vec3d normal(const Vec3d&) const override { return {0, 0, 1}; }
  Vec3d sampleObject(Vec2 u) const override {
    const double inner2 = innerRadius_ * innerRadius_;
    const double r = std::sqrt(inner2 + (radius_ * radius_ - inner2) * u.x);
    const Vec2 around = cosSinOfTurns(static_cast<float>(phiMax() / kTwoPi) * u.y);
    return {r * around.x, r * around.y, height_};
  }

  double height_, radius_, innerRadius_;
};

const RegisterPlugin<Shape, Disk> kRegistration{"disk", Origin::PbrtV2, "disk, ring or sector"};

}  // namespace

}  // namespace brume
