// SPDX-License-Identifier: Apache-2.0
// Choice of one light for a point, by what the lights can send to its surroundings.
#pragma once

#include <optional>
#include <vector>

#include "core/scene.h"

namespace brume {

/// The lights of the scene that emit anything at all (a black light costs shadow rays and gives
/// nothing).
std::vector<const Light*> emittingLights(const Scene& scene);

/// A coarse grid over the scene; each cell holds the cumulative probabilities of the lights,
/// 9/10 by their importance in the cell and 1/10 uniform among those that reach it, so that a
/// strong light behind a wall cannot starve the others. Probability 0 only where no light arrives.
class LightGrid {
 public:
  explicit LightGrid(const Scene& scene);

  struct Choice {
    const Light* light = nullptr;
    float probability = 0;
  };
  /// None when no light reaches the cell of p (render space).
  std::optional<Choice> choose(const Vec3& p, float u) const;
  /// Of choosing this light at p; 0 for a light that is not sampled.
  float probability(const Vec3& p, const Light* light) const;

  const std::vector<const Light*>& lights() const { return lights_; }
  /// Whether any light can be hit by a ray, so that sampling the BSDF finds light.
  bool hasHittableLights() const { return hasHittable_; }

 private:
  std::size_t cellOf(const Vec3& p) const;
  void fillCell(const Bounds3& cell, float* cdf) const;

  std::vector<const Light*> lights_;
  std::vector<std::pair<const Light*, std::size_t>> indexOf_;  // sorted by address
  bool hasHittable_ = false;
  Vec3 lo_{0}, cellsPerLength_{0};
  int n_[3] = {1, 1, 1};
  std::vector<float> cdf_;  // lights_.size() per cell, the last one 1 (or 0: no light arrives)
};

}  // namespace brume
