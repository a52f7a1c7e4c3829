// SPDX-License-Identifier: Apache-2.0
#include "transport/light_choice.h"

#include "transport/distance_sampling.h"

namespace brume {

namespace {

constexpr float kEvenShare = 0.1f;

/// Bounds of a stretch of a ray.
Bounds3 boundsOf(const Ray& ray, Interval range) {
  Bounds3 b;
  b.extend(ray(range.t0));
  b.extend(ray(range.t1));
  return b;
}

}  // namespace

LightChoice::LightChoice(std::span<const std::unique_ptr<Light>> lights) {
  for (const auto& light : lights)
    lights_.push_back({light.get(), light->power().luminance() * kInv4Pi});
}

void LightChoice::along(const Ray& ray, Interval range, Choices& choices) const {
  choices.chosen_.clear();
  choices.upTo_.clear();
  double sum = 0;
  for (const Entry& e : lights_) {
    const Interval part = e.light->illuminated(ray, range);
    if (part.isEmpty()) continue;
    const float importance = e.light->importance(boundsOf(ray, part));
    if (!(importance > 0)) continue;
    const auto position = e.light->position();
    float weight =
        position
            ? e.intensity * EquiangularSampler(ray, part, *position, e.light->extent()).integral()
            : importance * part.length();
    // Unbounded estimates are worth no more than a large number.
    weight = std::isfinite(weight) ? weight : 1e30f;
    choices.chosen_.push_back({e.light, part, weight});
    sum += double{weight};
  }

  const auto count = static_cast<float>(choices.chosen_.size());
  float upTo = 0;
  for (Choices::Chosen& c : choices.chosen_) {
    const float share = sum > 0 ? static_cast<float>(double{c.probability} / sum) : 1.f / count;
    c.probability = (1 - kEvenShare) * share + kEvenShare / count;
    choices.upTo_.push_back(upTo += c.probability);
  }
}

const LightChoice::Choices::Chosen& LightChoice::Choices::choose(float u) const {
  if (chosen_.size() == 1) return chosen_.front();
  const auto it = std::upper_bound(upTo_.begin(), upTo_.end(), u * upTo_.back());
  const auto i = static_cast<std::size_t>(it - upTo_.begin());
  return chosen_[std::min(i, chosen_.size() - 1)];
}

}  // namespace brume
