// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "core/light.h"

namespace brume {

/// Chooses the light that shines on a stretch of a ray. Weight of a light: its irradiance summed
/// along the stretch, visibility ignored,
///   Phi / (4 pi) Int 1/d^2 dt  with a position, else its importance there times the length.
/// A tenth of the probability is shared evenly by all lights that can arrive, so that none is ever
/// missed. Immutable; what varies per ray lies in a Choices that the caller reuses.
class LightChoice {
 public:
  explicit LightChoice(std::span<const std::unique_ptr<Light>> lights);
  bool isEmpty() const { return lights_.empty(); }
  std::size_t size() const { return lights_.size(); }

  /// The lights that can reach one stretch of a ray.
  class Choices {
   public:
    struct Chosen {
      const Light* light = nullptr;
      Interval illuminated;  ///< the part of the stretch that it can reach
      float probability = 0;
    };
    bool isEmpty() const { return chosen_.empty(); }
    const Chosen& choose(float u) const;
    std::span<const Chosen> all() const { return chosen_; }

   private:
    friend class LightChoice;
    std::vector<Chosen> chosen_;
    std::vector<float> upTo_;  // cumulative probability
  };
  void along(const Ray& ray, Interval range, Choices& choices) const;

 private:
  struct Entry {
    const Light* light;
    float intensity;  // power over the sphere [W/sr]
  };
  std::vector<Entry> lights_;
};

}  // namespace brume
