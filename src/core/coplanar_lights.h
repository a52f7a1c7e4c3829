// SPDX-License-Identifier: Apache-2.0
// Area lights that lie exactly in another surface: a lamp drawn into the plane of its ceiling.
#pragma once

#include <memory>
#include <vector>

#include "core/accelerator.h"

namespace brume {

/// Which of two surfaces in one plane a ray meets first is decided by rounding. Where one of them
/// is a light that would be wrong as often as not: shadow rays end in front of both and always find
/// the light, so rays that hit it have to as well, or the light that they stand for is lost (8 %
/// where a ceiling is lit by its lamp). So the light wins. Only surfaces that touch a light are
/// looked at again: those with a triangle in the plane of a flat light, and whatever overlaps the
/// bounds of another one. Surfaces inside object instances are left alone, as are their lights.
/// Test: coplanar_lights_test.
class CoplanarLights {
 public:
  /// The primitives of the scene, which outlive this.
  explicit CoplanarLights(const std::vector<Primitive>& primitives);

  /// Whether a light may lie in this primitive of the scene.
  bool mayBeIn(const Primitive& primitive) const {
    return !inLight_.empty() && inLight_[static_cast<std::size_t>(&primitive - first_)];
  }
  /// The light that the ray meets within `slack` (a length) of t, by a ray that starts there.
  struct Found {
    Ray ray;
    SceneHit hit;
  };
  std::optional<Found> at(const Ray& ray, float t, float slack) const;

 private:
  const Primitive* first_ = nullptr;
  std::vector<bool> inLight_;           // of each primitive; empty: none
  std::vector<PrimitiveGroup> lights_;  // one group
  std::unique_ptr<Accelerator> accelerator_;
};

}  // namespace brume
