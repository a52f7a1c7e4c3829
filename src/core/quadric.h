// SPDX-License-Identifier: Apache-2.0
// What sphere, disk, cylinder, cone, paraboloid and hyperboloid share. All are surfaces of
// revolution about the z axis of their object space; all geometry there is done in double, so that
// the hit, its refinement and its error bound do not depend on where the ray comes from.
#pragma once

#include <array>
#include <optional>

#include "core/shape.h"

namespace brume {

/// Base of the shapes with an implicit equation  x^2 + y^2 = q(z) = q0 + q1 z + q2 z^2.
class Quadric : public Shape {
 public:
  Bounds3 bounds() const final { return bounds_; }
  float area() const final;
  std::optional<ShapeHit> intersect(const Ray& ray) const final;
  SurfaceInteraction interaction(const Ray& ray, const ShapeHit& hit) const final;
  ShapeSample sampleArea(Vec2 u) const final;
  float pdfArea(const Vec3& p, const Vec3& n) const final;

 protected:
  static constexpr double kTwoPi = 6.28318530717958647692;

  /// Coefficients of q(z), and a z in the middle of the shape (the ray is solved from near there).
  struct Profile {
    double q0 = 0, q1 = 0, q2 = 0;
    double zMiddle = 0;
    double at(double z) const { return q0 + z * (q1 + z * q2); }
    double slope(double z) const { return q1 + 2 * q2 * z; }
  };
  /// Object-space box and area of the part that exists, and its normal if all points share it.
  struct Extent {
    Vec3d lo{0}, hi{0};
    double area = 0;
    std::optional<Vec3d> normal{};
  };
  /// Parameters and their derivatives at a point of the surface, in object space. n is unit, along
  /// dpdu x dpdv also where that vanishes (poles, apex).
  struct Local {
    double u = 0, v = 0;
    Vec3d dpdu{0}, dpdv{0};
    Vec3d duu{0}, duv{0}, dvv{0};  // second derivatives of p
    Vec3d n{0, 0, 1};
  };
  using Roots = std::array<double, 2>;  // ascending; infinite or NaN where there is none
  /// Where a point lies around the axis: radius, kept off 0 so that derivatives exist at poles.
  struct Polar {
    double radius = 0, cosPhi = 1, sinPhi = 0, phi = 0;
  };

  Quadric(const FactoryContext& context, const Profile& profile, double phiMaxDegrees);
  /// To be called by the constructor of the shape when its own data are ready. SceneError when the
  /// shape reaches beyond what Embree can hold.
  void setExtent(const Extent& extent, const SourceLocation& where);

  /// Ray parameters at which o + t d meets the unclipped surface.
  virtual Roots roots(const Vec3d& o, const Vec3d& d) const;
  /// The point of the surface next to p, which is near it.
  virtual Vec3d project(const Vec3d& p) const;
  /// Whether a point of the unclipped surface belongs to the shape.
  virtual bool exists(const Vec3d& p) const = 0;
  virtual Local local(const Vec3d& p) const = 0;
  /// n of local(p), which is all that a sampled point needs.
  virtual Vec3d normal(const Vec3d& p) const { return local(p).n; }
  /// A point uniform by area in object space.
  virtual Vec3d sampleObject(Vec2 u) const = 0;

  bool phiExists(double x, double y) const;
  static Polar polar(const Vec3d& p, double smallestRadius);

  const Profile& profile() const { return profile_; }
  double phiMax() const { return phiMax_; }
  Vec3d toObject(const Vec3& p) const;
  Vec3d vectorToObject(const Vec3d& v) const;
  /// |det| of the map from shape to object space.
  double objectVolumeRatio() const { return 1 / volumeRatio_; }
  /// A sample at a point of the surface and its unit normal there, in object space; pdf left to the
  /// caller.
  ShapeSample sampleAt(const Vec3d& object, const Vec3d& n) const;

 private:
  Vec3 toShape(const Vec3d& object, Vec3* error) const;
  Vec3d vectorToShape(const Vec3d& v) const;
  /// Unit, on the side that the hit shows: the object's own side unless orientation is reversed.
  Vec3d normalToShape(const Vec3d& n) const;
  /// Whether objectToShape scales all directions alike.
  bool isSimilarity() const;
  /// Area in shape space of a unit area in object space around normal n (unit, object space).
  double areaRatio(const Vec3d& n) const;

  Transform objectToShape_;
  double volumeRatio_ = 1;  // |det| of objectToShape
  bool reverseOrientation_ = false;
  Profile profile_;
  double phiMax_ = kTwoPi;
  double objectArea_ = 0;
  Bounds3 bounds_;
  std::optional<Vec3> onlyNormal_;    // in shape space
  std::optional<float> onlyPdfArea_;  // where the area ratio is the same everywhere
};

}  // namespace brume
