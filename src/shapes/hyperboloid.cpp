// SPDX-License-Identifier: Apache-2.0
#include "core/quadric.h"
#include "core/registry.h"

namespace brume {

namespace {

/// What the segment from p1 to p2 sweeps when it turns around the z axis: a hyperboloid, or a cone
/// or cylinder. Its normal points away from the axis when p2 is above p1, else towards it.
///   u = phi / phimax from the segment's own azimuth, v = 0 at p1 to 1 at p2
/// With r1^2 = |p1.xy|^2, d = p2 - p1 and v = (z - p1.z) / d.z,
///   x^2 + y^2 = r1^2 + 2 (p1 . d)_xy v + |d.xy|^2 v^2
/// which holds wherever the waist lies; PBRT-v2 wants it at z = 0. Its exchange of p1 and p2 when
/// p2.z = 0 is kept, scenes depend on it. Test: quadric_test.
class Hyperboloid final : public Quadric {
 public:
  struct Params {
    Vec3 p1{0, 0, 0}, p2{1, 1, 1};
    float phimax = 360;
    void visit(ParamVisitor& v) {
      v.point(p1, "p1", Unit::Length, "one end of the segment");
      v.point(p2, "p2", Unit::Length, "the other end, at another height");
      v(phimax, "phimax", {0.f, 360.f, true}, Unit::Degrees, "largest angle that it turns by");
    }
  };

  Hyperboloid(Params params, const FactoryContext& context)
      : Quadric(context, profileOf(params, context.where), params.phimax),
        p1_(params.p2.z == 0.f ? params.p2 : params.p1),
        d_(Vec3d(params.p2.z == 0.f ? params.p1 : params.p2) - p1_) {
    // |dp/dphi x dp/dv|^2 = r^2 d.z^2 + ((p . d)_xy)^2 is a quadratic a w^2 + c of w = v - v0: the
    // area up to v has a closed form.
    const double along2 = d_.x * d_.x + d_.y * d_.y, start = p1_.x * d_.x + p1_.y * d_.y;
    const double r12 = p1_.x * p1_.x + p1_.y * p1_.y, z2 = d_.z * d_.z;
    a_ = along2 * (z2 + along2);
    v0_ = along2 > 0 ? -start / along2 : 0;
    const double waist2 = along2 > 0 ? std::max(0.0, r12 - start * start / along2) : r12;
    c_ = waist2 * z2;
    if (!(c_ > 0) && !(a_ > 0))
      throw SceneError(context.where, "hyperboloid: p1 and p2 both lie on the z axis");

    const double rMax = std::sqrt(std::max(r12, r12 + 2 * start + along2));
    const double z1 = p1_.z, z2End = p1_.z + d_.z;
    setExtent({{-rMax, -rMax, std::min(z1, z2End)},
               {rMax, rMax, std::max(z1, z2End)},
               phiMax() * (areaUpTo(1) - areaUpTo(0))},
              context.where);
  }

 private:
  static Profile profileOf(const Params& params, const SourceLocation& where) {
    const Vec3d p1(params.p1), d = Vec3d(params.p2) - p1;
    if (d.z == 0)
      throw SceneError(where, "hyperboloid: p1 and p2 must differ in z (a flat ring is a disk)");
    const double linear = 2 * (p1.x * d.x + p1.y * d.y) / d.z;
    const double quadratic = (d.x * d.x + d.y * d.y) / (d.z * d.z);
    Profile profile;
    profile.q0 = p1.x * p1.x + p1.y * p1.y - linear * p1.z + quadratic * p1.z * p1.z;
    profile.q1 = linear - 2 * quadratic * p1.z;
    profile.q2 = quadratic;
    profile.zMiddle = p1.z + 0.5 * d.z;
    return profile;
  }

  /// Integral of sqrt(a w^2 + c) up to v, per unit of phi.
  double areaUpTo(double v) const {
    const double w = v - v0_, root = std::sqrt(a_ * w * w + c_);
    if (!(a_ > 0)) return root * w;
    const double ratio = std::sqrt(a_ / std::max(c_, 1e-300));
    return 0.5 * (w * root + (c_ > 0 ? c_ / std::sqrt(a_) * std::asinh(ratio * w) : 0));
  }
  bool exists(const Vec3d& p) const override {
    const double v = (p.z - p1_.z) / d_.z;
    if (!(v >= 0 && v <= 1)) return false;
    const Vec3d q = p1_ + d_ * v;
    return phiExists(p.x * q.x + p.y * q.y, q.x * p.y - p.x * q.y);
  }
  Local local(const Vec3d& p) const override;
  Vec3d sampleObject(Vec2 u) const override;

  Vec3d p1_, d_;
  double a_ = 0, c_ = 0, v0_ = 0;
};

Quadric::Local Hyperboloid::local(const Vec3d& p) const {
  Local l;
  l.v = (p.z - p1_.z) / d_.z;
  const Vec3d q = p1_ + d_ * l.v;
  double phi = std::atan2(q.x * p.y - p.x * q.y, p.x * q.x + p.y * q.y);
  if (phi < 0) phi += kTwoPi;
  l.u = phi / phiMax();
  const double c = std::cos(phi), s = std::sin(phi);
  const double smallest = 1e-5 * std::sqrt(a_ + c_) / length(d_);
  const Polar at = polar(p, smallest);
  const double x = at.radius * at.cosPhi, y = at.radius * at.sinPhi;
  l.dpdu = Vec3d(-y, x, 0) * phiMax();
  l.dpdv = Vec3d(d_.x * c - d_.y * s, d_.x * s + d_.y * c, d_.z);
  l.duu = Vec3d(-x, -y, 0) * (phiMax() * phiMax());
  l.duv = Vec3d(-l.dpdv.y, l.dpdv.x, 0) * phiMax();
  l.n = normalize(cross(l.dpdu, l.dpdv));
  return l;
}

Vec3d Hyperboloid::sampleObject(Vec2 u) const {
  // The area up to v grows strictly: Newton's iteration kept inside a bisection.
  const double from = areaUpTo(0), target = from + (areaUpTo(1) - from) * u.x;
  double lo = 0, hi = 1, v = u.x;
  for (int i = 0; i < 60 && hi - lo > 1e-15; ++i) {
    const double excess = areaUpTo(v) - target;
    (excess > 0 ? hi : lo) = v;
    const double w = v - v0_, next = v - excess / std::sqrt(a_ * w * w + c_);
    if (std::abs(next - v) < 1e-15) break;
    v = next > lo && next < hi ? next : 0.5 * (lo + hi);
  }
  const Vec3d q = p1_ + d_ * v;
  const double phi = phiMax() * u.y, c = std::cos(phi), s = std::sin(phi);
  return {q.x * c - q.y * s, q.x * s + q.y * c, q.z};
}

const RegisterPlugin<Shape, Hyperboloid> kRegistration{"hyperboloid", Origin::PbrtV2,
                                                       "a segment turned around the z axis"};

}  // namespace

}  // namespace brume
