// SPDX-License-Identifier: Apache-2.0
#include "transport/surface_share.h"

#include <bit>

#include "core/rng.h"
#include "core/sampling.h"

namespace brume {
namespace {

constexpr int kDirections = 8;

/// A number in [0, 1) that differs from point to point.
float chance(const Vec3& p, std::uint32_t purpose) {
  const std::uint64_t hash =
      hashIntegers(purpose, std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y),
                   std::bit_cast<std::uint32_t>(p.z));
  return static_cast<float>(hash >> 40) * 0x1p-24f;
}

/// The part of the way that is free, 1: all of it.
float freeShare(const Accelerator& accelerator, const Ray& ray) {
  const auto hit = accelerator.intersect(ray);
  return hit ? std::clamp(hit->shape.t / ray.tMax, 0.f, 1.f) : 1.f;
}

Vec3 upAt(const SurfaceInteraction& at) { return dot(at.n, at.wo) < 0 ? -at.n : at.n; }

}  // namespace

float chanceOf(const Vec3& p) { return chance(p, 1); }

bool isBehindAnEdge(const Accelerator& accelerator, const SurfaceInteraction& at, const Vec3& p,
                    float slab) {
  const float along = distance(p, at.p);
  if (!(along > 0)) return false;
  return accelerator.occluded(Ray{at.p + slab * upAt(at), (p - at.p) / along, along, at.time});
}

float surfaceShare(const Accelerator& accelerator, const SurfaceInteraction& at, float radius,
                   float slab) {
  const Vec3 up = upAt(at);
  const Frame frame = Frame::fromZ(up);
  const float turn = chance(at.p, 0);
  float share = 0;
  for (int j = 0; j < kDirections; ++j) {
    const float phi = 2 * kPi * (static_cast<float>(j) + turn) / kDirections;
    const Vec3 along = frame.x * std::cos(phi) + frame.y * std::sin(phi);
    const float above = freeShare(accelerator, Ray{at.p + slab * up, along, radius, at.time});
    const float below =
        freeShare(accelerator, Ray{at.p - slab * up + radius * along, -along, radius, at.time});
    // A hit on the way back from outside is where the surface has fallen away.
    const float rho = std::min(above, below < 1 ? 1 - below : 1.f);
    const float rest = 1 - sqr(rho);
    share += 1 - rest * rest * rest;
  }
  return std::max(share / kDirections, kLeastShare);
}

}  // namespace brume
