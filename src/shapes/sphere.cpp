// SPDX-License-Identifier: Apache-2.0
#include "core/quadric.h"
#include "core/registry.h"
#include "core/sampling.h"

namespace brume {

namespace {

/// Sphere around the origin, or the part with zmin <= z <= zmax and azimuth up to phimax.
///   u = phi / phimax, v from 0 at zmin to 1 at zmax, linear in the polar angle
/// As a light, a whole sphere (an ellipsoid too) is sampled uniformly in the cone that it fills in
/// object space as seen from outside; a part, or from inside, by area. Source: Pharr, Jakob,
/// Humphreys 2016, 14.2.2. Test: quadric_test.
class Sphere final : public Quadric {
 public:
  struct Params {
    float radius = 1;
    std::optional<float> zmin, zmax;
    float phimax = 360;
    void visit(ParamVisitor& v) {
      v(radius, "radius", kPositive, Unit::Length, "radius");
      v(zmin, "zmin", kAnyFloat, Unit::Length, "lower cut; nothing is cut when absent");
      v(zmax, "zmax", kAnyFloat, Unit::Length, "upper cut; nothing is cut when absent");
      v(phimax, "phimax", {0.f, 360.f, true}, Unit::Degrees, "largest azimuth");
    }
  };

  Sphere(Params params, const FactoryContext& context)
      : Quadric(context, profileOf(params), params.phimax),
        radius_(params.radius),
        zMin_(params.zmin.value_or(-params.radius)),
        zMax_(params.zmax.value_or(params.radius)) {
    if (!(zMin_ < zMax_)) throw SceneError(context.where, "sphere: zmin must be smaller than zmax");
    if (zMin_ >= radius_ || zMax_ <= -radius_)
      throw SceneError(context.where, "sphere: nothing is left between zmin and zmax");
    // Planes beyond the poles cut nothing.
    cutsBelow_ = zMin_ > -radius_;
    cutsAbove_ = zMax_ < radius_;
    zMin_ = std::max(zMin_, -radius_);
    zMax_ = std::min(zMax_, radius_);
    thetaMin_ = std::acos(zMin_ / radius_);
    thetaRange_ = std::acos(zMax_ / radius_) - thetaMin_;
    setExtent({{-radius_, -radius_, zMin_},
               {radius_, radius_, zMax_},
               phiMax() * radius_ * (zMax_ - zMin_)},
              context.where);
  }

  std::optional<ShapeSample> sampleSolidAngle(const Vec3& ref, Vec2 u) const override;
  float pdfSolidAngle(const Vec3& ref, const Vec3& wi, const Vec3& hitPoint,
                      const Vec3& hitNormal) const override;

 private:
  static Profile profileOf(const Params& params) {
    return {static_cast<double>(params.radius) * params.radius, 0, -1, 0};
  }
  bool exists(const Vec3d& p) const override {
    return !(cutsBelow_ && p.z < zMin_) && !(cutsAbove_ && p.z > zMax_) && phiExists(p.x, p.y);
  }
  Local local(const Vec3d& p) const override;
  Vec3d normal(const Vec3d& p) const override { return normalize(p); }
  Vec3d sampleObject(Vec2 u) const override {
    const double z = zMin_ + (zMax_ - zMin_) * u.x, phi = phiMax() * u.y;
    const double radius = std::sqrt(std::max(0.0, radius_ * radius_ - z * z));
    return {radius * std::cos(phi), radius * std::sin(phi), z};
  }
  /// 1 - cos of the half-angle of the cone that the sphere fills as seen from a point of object
  /// space; none when it is not seen as a whole from outside. A point within 1e-4 radii of the
  /// surface may be one of the surface itself, lit by the sphere's inside: it is not outside.
  std::optional<double> coneFrom(const Vec3d& p) const {
    constexpr double kOutside = 1 - 2e-4;
    const double sin2 = radius_ * radius_ / dot(p, p);
    if (cutsBelow_ || cutsAbove_ || phiMax() < kTwoPi || !(sin2 < kOutside)) return std::nullopt;
    return sin2 / (1 + std::sqrt(1 - sin2));
  }
  /// Density per solid angle in shape space for one in object space; wi is of length l, in shape
  /// space.
  double densityInShapeSpace(double oneMinusCos, const Vec3d& wi, double l) const {
    const double stretch = length(vectorToObject(wi)) / l;
    return objectVolumeRatio() / (stretch * stretch * stretch * kTwoPi * oneMinusCos);
  }

  double radius_, zMin_, zMax_;
  bool cutsBelow_ = false, cutsAbove_ = false;
  double thetaMin_ = 0, thetaRange_ = 0;
};

Quadric::Local Sphere::local(const Vec3d& p) const {
  const Polar at = polar(p, 1e-5 * radius_);
  Local l;
  l.u = at.phi / phiMax();
  l.v = (std::atan2(std::sqrt(p.x * p.x + p.y * p.y), p.z) - thetaMin_) / thetaRange_;
  const double x = at.radius * at.cosPhi, y = at.radius * at.sinPhi;
  l.dpdu = Vec3d(-y, x, 0) * phiMax();
  l.dpdv = Vec3d(p.z * at.cosPhi, p.z * at.sinPhi, -at.radius) * thetaRange_;
  l.duu = Vec3d(-x, -y, 0) * (phiMax() * phiMax());
  l.duv = Vec3d(-at.sinPhi, at.cosPhi, 0) * (thetaRange_ * p.z * phiMax());
  l.dvv = Vec3d(x, y, p.z) * (-thetaRange_ * thetaRange_);
  l.n = normal(p);
  return l;
}

std::optional<ShapeSample> Sphere::sampleSolidAngle(const Vec3& ref, Vec2 u) const {
  const Vec3d from = toObject(ref);
  const std::optional<double> cone = coneFrom(from);
  if (!cone) return Quadric::sampleSolidAngle(ref, u);

  // A direction of the cone by its 1 - cos, which keeps its precision however far the sphere is.
  const double oneMinusCos = *cone * u.x, cosTheta = 1 - oneMinusCos;
  const double sin2 = oneMinusCos * (2 - oneMinusCos);
  const double distance = length(from);
  const float phi = 2.f * kPi * u.y;
  const Vec3d axis = from * (1 / distance);
  const Vec3d side = normalize(std::abs(axis.x) > std::abs(axis.y) ? Vec3d(axis.z, 0, -axis.x)
                                                                   : Vec3d(0, -axis.z, axis.y));
  const Vec3d up = cross(side, axis);
  const Vec3d around = side * double{std::cos(phi)} + up * double{std::sin(phi)};

  // Where it enters the sphere: alpha is the angle there, seen from the sphere's centre, between
  // the reference point and the point of entry.
  const double relativeDistance = distance / radius_;
  const double inside = std::max(0.0, 1 - sin2 * relativeDistance * relativeDistance);
  const double cosAlpha = sin2 * relativeDistance + cosTheta * std::sqrt(inside);
  const double sinAlpha = std::sqrt(std::max(0.0, 1 - cosAlpha * cosAlpha));
  const Vec3d n = axis * cosAlpha + around * sinAlpha;
  ShapeSample sample = sampleAt(n * radius_, n);
  const Vec3d toLight = Vec3d(sample.p) - Vec3d(ref);
  const double d = length(toLight);
  if (!(d > 0)) return std::nullopt;
  sample.pdf = static_cast<float>(densityInShapeSpace(*cone, toLight, d));
  if (!(sample.pdf > 0.f) || !std::isfinite(sample.pdf)) return std::nullopt;
  return sample;
}

float Sphere::pdfSolidAngle(const Vec3& ref, const Vec3& wi, const Vec3& hitPoint,
                            const Vec3& hitNormal) const {
  const std::optional<double> cone = coneFrom(toObject(ref));
  if (!cone) return Quadric::pdfSolidAngle(ref, wi, hitPoint, hitNormal);
  return static_cast<float>(densityInShapeSpace(*cone, Vec3d(wi), 1));
}

const RegisterPlugin<Shape, Sphere> kRegistration{"sphere", Origin::PbrtV2,
                                                  "sphere, or a part of one"};

}  // namespace

}  // namespace brume
