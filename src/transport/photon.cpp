// SPDX-License-Identifier: Apache-2.0
#include "transport/photon.h"

namespace brume {
namespace {

constexpr std::string_view kClassTexts[kPhotonClasses] = {
    "on surfaces, straight from the lights",
    "of caustics on surfaces",
    "of indirect light on surfaces",
    "in the media, straight from the lights",
    "of caustics in the media",
    "of multiply scattered light in the media"};

/// A unit vector on the octahedron |x| + |y| + |z| = 1, its lower half folded out: [-1, 1]^2.
Vec2 toOctahedron(const Vec3& v) {
  const float scale = 1 / (std::abs(v.x) + std::abs(v.y) + std::abs(v.z));
  const Vec2 p(v.x * scale, v.y * scale);
  if (v.z >= 0) return p;
  return {std::copysign(1 - std::abs(p.y), p.x), std::copysign(1 - std::abs(p.x), p.y)};
}

Vec3 fromOctahedron(const Vec2& p) {
  Vec3 v(p.x, p.y, 1 - std::abs(p.x) - std::abs(p.y));
  if (v.z < 0) {
    v.x = std::copysign(1 - std::abs(p.y), p.x);
    v.y = std::copysign(1 - std::abs(p.x), p.y);
  }
  return normalize(v);
}

/// [-1, 1] to an even number of steps, so that 0 and +-1 are exact.
template <int kBits>
std::uint32_t quantise(float x) {
  constexpr float kHalf = static_cast<float>((1 << (kBits - 1)) - 1);
  return static_cast<std::uint32_t>(
      static_cast<std::int32_t>((std::clamp(x, -1.f, 1.f) + 1) * kHalf + 0.5f));
}
template <int kBits>
float dequantise(std::uint32_t q) {
  constexpr float kHalf = static_cast<float>((1 << (kBits - 1)) - 1);
  return std::min(static_cast<float>(q & ((1u << kBits) - 1)) / kHalf - 1, 1.f);
}

}  // namespace

std::string_view describe(PhotonClass c) { return kClassTexts[static_cast<std::size_t>(c)]; }

PackedDirection::PackedDirection(const Vec3& unit) {
  const Vec2 p = toOctahedron(unit);
  bits_ = quantise<16>(p.x) | quantise<16>(p.y) << 16;
}

Vec3 PackedDirection::unpack() const {
  return fromOctahedron({dequantise<16>(bits_), dequantise<16>(bits_ >> 16)});
}

Vec3 Photon::normal() const {
  return fromOctahedron({dequantise<12>(bits >> 8), dequantise<12>(bits >> 20)});
}

Photon Photon::inMedium(const Vec3& p, const Vec3& wi, const Rgb& power, PhotonClass c) {
  return {p, power, PackedDirection(wi), static_cast<std::uint32_t>(c)};
}

Photon Photon::onSurface(const Vec3& p, const Vec3& wi, const Vec3& n, const Rgb& power,
                         PhotonClass c) {
  const Vec2 o = toOctahedron(n);
  return {p, power, PackedDirection(wi),
          static_cast<std::uint32_t>(c) | quantise<12>(o.x) << 8 | quantise<12>(o.y) << 20};
}

}  // namespace brume
