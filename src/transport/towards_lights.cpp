// SPDX-License-Identifier: Apache-2.0
#include "transport/towards_lights.h"

#include <bit>

#include "core/rng.h"

namespace brume {

namespace {

/// Lights this near to a medium, in its diagonals, count as inside: light scattered along a ray
/// grows almost as much.
constexpr float kNear = 0.02f;

bool isNear(const Vec3& p, Bounds3 bounds) {
  const Vec3 margin(kNear * length(bounds.diagonal()));
  bounds.lo -= margin;
  bounds.hi += margin;
  return bounds.contains(p);
}

}  // namespace

TowardsLights::TowardsLights(const Scene& scene) {
  for (const auto& light : scene.lights()) {
    const auto position = light->position();
    if (!light->isDelta() || !position || light->power().isBlack()) continue;
    for (const auto& volume : scene.contents().volumes)
      if (volume->isScattering() && isNear(*position, volume->bounds())) {
        lights_.push_back({*position, lightWeight(light->power())});
        break;
      }
  }
}

TowardsLights::Directions TowardsLights::from(const Vec3& p, float u) const {
  Directions result;
  if (lights_.empty()) return result;
  Rng rng(hashIntegers(std::bit_cast<std::uint32_t>(u)));
  const std::size_t count = std::min(lights_.size(), kMost);
  float sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Entry& light =
        lights_[lights_.size() <= kMost ? i
                                        : rng.below(static_cast<std::uint32_t>(lights_.size()))];
    const Vec3d d = Vec3d(light.position) - Vec3d(p);
    const double l = length(d);
    if (!(l > 0)) continue;
    // Light scattered twice falls off like 1 / distance.
    const auto weight = static_cast<float>(double{light.intensity} / l);
    result.towards_[result.count_] = Vec3(d * (1 / l));
    result.probability_[result.count_++] = weight;
    sum += weight;
  }
  if (!(sum > 0) || !std::isfinite(sum)) return {};
  for (std::size_t i = 0; i < result.count_; ++i) result.probability_[i] /= sum;
  return result;
}

Vec3 TowardsLights::Directions::sample(Vec2 u) const {
  std::size_t i = 0;
  while (i + 1 < count_ && u.x >= probability_[i]) u.x -= probability_[i++];
  const float v = std::clamp(u.x / probability_[i], 0.f, kOneMinusEpsilon);
  const float theta = kPi * v, phi = 2 * kPi * u.y, sine = std::sin(theta);
  return normalize(Frame::fromZ(towards_[i])
                       .fromLocal({sine * std::cos(phi), sine * std::sin(phi), std::cos(theta)}));
}

float TowardsLights::Directions::pdf(const Vec3& w) const {
  float sum = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    // Unit vectors in float tell no smaller angles apart.
    const float sine = std::max(length(cross(w, towards_[i])), 1e-7f);
    sum += probability_[i] / sine;
  }
  return sum * (0.5f * kInvPi * kInvPi);
}

}  // namespace brume
