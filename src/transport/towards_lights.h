// SPDX-License-Identifier: Apache-2.0
// Directions of rays that pass near point lights in media.
#pragma once

#include <array>
#include <vector>

#include "core/scene.h"

namespace brume {

/// Around a light of no size in a medium the light scattered along a ray grows like 1 / D, D its
/// distance from the ray: drawn from a phase function or BSDF alone, directions have no finite
/// variance there. A quarter of them is therefore drawn around the directions to such lights,
///   pdf(w) = 1 / (2 pi^2 sin theta)      [1/sr], theta the angle to the light,
/// which grows as fast as what is looked for. Test: towards_lights_test.
class TowardsLights {
 public:
  /// Lights looked at from one vertex. Of more than that a few are drawn for each vertex anew.
  static constexpr std::size_t kMost = 8;

  /// Remembers the lights that have a position, no size, and stand in scattering
  /// media, or close to them.
  explicit TowardsLights(const Scene& scene);
  bool isEmpty() const { return lights_.empty(); }

  /// As seen from one vertex.
  class Directions {
   public:
    bool isEmpty() const { return count_ == 0; }
    /// Share of the directions that is drawn here: 0 when there is no light.
    float share() const { return isEmpty() ? 0.f : kShare; }
    Vec3 sample(Vec2 u) const;
    /// Per solid angle.
    float pdf(const Vec3& w) const;
    /// Of the mixture with another way of sampling.
    float mixed(const Vec3& w, float other) const {
      return isEmpty() ? other : (1 - kShare) * other + kShare * pdf(w);
    }

   private:
    friend class TowardsLights;
    static constexpr float kShare = 0.25f;
    std::size_t count_ = 0;
    std::array<Vec3, kMost> towards_{};  // unit
    std::array<float, kMost> probability_{};
  };
  /// u chooses among many lights.
  Directions from(const Vec3& p, float u) const;

 private:
  struct Entry {
    Vec3 position;
    float intensity;
  };
  std::vector<Entry> lights_;
};

}  // namespace brume
