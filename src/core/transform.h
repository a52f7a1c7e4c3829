// SPDX-License-Identifier: Apache-2.0
// Affine transforms. GLM cannot tell points, vectors and normals apart; these functions do.
#pragma once

#include "core/math.h"
#include "core/ray.h"

namespace brume {

/// An invertible affine map between two spaces, with its inverse; kept in double, applied in float.
class Transform {
 public:
  Transform() : m_(1.0), inverse_(1.0) {}
  /// m maps column vectors; it must be invertible (isInvertible), its inverse is computed here.
  explicit Transform(const Mat4d& m);
  Transform(const Mat4d& m, const Mat4d& inverse);

  static Transform translate(const Vec3d& delta);
  static Transform scale(double x, double y, double z);
  /// Rotation by degrees about a non-zero axis.
  static Transform rotate(double degrees, const Vec3d& axis);
  /// World to camera space: the camera at eye looks along its +z to look, +y towards up
  /// (left-handed, as PBRT-v2). None when eye equals look or up is parallel to the direction.
  static std::optional<Transform> lookAt(const Vec3d& eye, const Vec3d& look, const Vec3d& up);
  /// All sixteen entries finite and the determinant of the 3x3 part not negligible against its
  /// scale.
  static bool isInvertible(const Mat4d& m);

  Transform inverse() const { return {inverse_, m_}; }
  /// First o, then this.
  Transform operator*(const Transform& o) const { return {m_ * o.m_, o.inverse_ * inverse_}; }
  bool operator==(const Transform& o) const { return m_ == o.m_; }

  Vec3 point(const Vec3& p) const;
  Vec3 vector(const Vec3& v) const;
  /// By the inverse transpose; not normalised.
  Vec3 normal(const Vec3& n) const;
  Bounds3 bounds(const Bounds3& b) const;
  /// Origin and direction; t keeps its meaning because the direction is not normalised again.
  Ray ray(const Ray& r) const;
  /// point(p) and a bound on its absolute error, for an input that is exact or in error by pError.
  Vec3 point(const Vec3& p, const Vec3& pError, Vec3* error) const;

  /// Whether it mirrors (negative determinant).
  bool swapsHandedness() const;
  /// Whether it changes lengths of the unit axes by more than 0.1 %.
  bool hasScale() const;
  const Mat4d& matrix() const { return m_; }
  const Mat4d& inverseMatrix() const { return inverse_; }

 private:
  Mat4d m_, inverse_;
  Mat4 f_{1.f}, inverseF_{1.f};  // the same in float, for application
  void updateFloats();
};

/// A transform that moves between two times: translation linear, rotation by quaternion slerp,
/// stretch linear (polar decomposition, as PBRT-v2). Outside [t0, t1] the end transforms hold.
class AnimatedTransform {
 public:
  AnimatedTransform() = default;
  explicit AnimatedTransform(const Transform& still) : start_(still), end_(still) {}
  AnimatedTransform(const Transform& start, float t0, const Transform& end, float t1);

  bool isAnimated() const { return animated_; }
  const Transform& start() const { return start_; }
  const Transform& end() const { return end_; }
  float startTime() const { return t0_; }
  float endTime() const { return t1_; }
  Transform at(float time) const;
  /// Bounds of everything that b sweeps (conservative for the sampled motion, 128 steps).
  Bounds3 motionBounds(const Bounds3& b) const;

 private:
  struct Decomposed {
    Vec3d translation{0};
    double rotation[4] = {1, 0, 0, 0};  // unit quaternion w, x, y, z
    Mat4d stretch{1.0};
  };
  static Decomposed decompose(const Mat4d& m);

  Transform start_, end_;
  float t0_ = 0, t1_ = 1;
  bool animated_ = false;
  Decomposed d0_, d1_;
};

}  // namespace brume
