// SPDX-License-Identifier: Apache-2.0
// Emitting media as a light: directions from a point towards where they shine.
#pragma once

#include <optional>

#include "core/medium_along_ray.h"
#include "core/scene.h"

namespace brume {

/// Directions from any point to points y of the media drawn in proportion to their emission. The
/// point only gives the direction; what shines along it is the integral of the whole ray, so its
/// density is that of all points that lead to it,
///   pdf(w) = Int_0^inf Le(x + t w) t^2 dt / Int Le dV        [1/sr], of the luminances,
/// exact, and also known for directions that were drawn otherwise: both can be weighted against
/// each other. Test: emission_sampling_test.
class EmissionSampler {
 public:
  explicit EmissionSampler(const Scene& scene);
  /// Nothing emits: no other function may be called.
  bool isEmpty() const { return !(total_ > 0); }
  /// Where the media are and how brightly they shine, attenuated by themselves.
  LightBounds bounds() const { return bounds_; }
  /// Directions drawn evenly from p meet what emits in less than 15 % of all cases: it is taken as
  /// a ball of the effective volume (Int Le dV)^2 / Int Le^2 dV.
  bool isSeldomHit(const Vec3& p) const;
  /// A direction from p; none where the point drawn is p itself.
  std::optional<Vec3> sample(const Vec3& p, Vec2 u) const;
  /// The part of the ray that may hold emitting media; none when it misses them.
  std::optional<Interval> emittersAlong(const Ray& ray) const { return emitters_->intersect(ray); }
  /// Density per solid angle of the ray's direction at its origin. `medium` holds the media along
  /// the ray up to the surface it meets, or all of them; what lies beyond is looked up.
  float pdf(const Ray& ray, const MediumAlongRay& medium) const;

 private:
  void findBall();

  double total_ = 0;  // Int Le dV, luminance
  LightBounds bounds_;
  std::unique_ptr<Volume> aggregate_;
  const Volume* emitters_ = nullptr;  // the emitting volumes alone
  Vec3d center_{0};                   // the ball of isSeldomHit
  double radius2_ = 0;                // its radius squared
};

}  // namespace brume
