// SPDX-License-Identifier: Apache-2.0
#include "transport/photon.h"

#include "transport/octahedron.h"

namespace brume {
namespace {

constexpr std::string_view kClassTexts[kPhotonClasses] = {
    "on surfaces, straight from the lights",
    "of caustics on surfaces",
    "of indirect light on surfaces",
    "in the media, straight from the lights",
    "of caustics in the media",
    "of multiply scattered light in the media"};

Vec3 fromOctahedron(const Vec2& p) {
  Vec3 v(p.x, p.y, 1 - std::abs(p.x) - std::abs(p.y));
  if (v.z < 0) {
    v.x = std::copysign(1 - std::abs(p.y), p.x);
    v.y = std::copysign(1 - std::abs(p.x), p.y);
  }
  return normalize(v);
}

template <int kBits>
float dequantise(std::uint32_t q) {
  constexpr float kHalf = static_cast<float>((1 << (kBits - 1)) - 1);
  return std::min(static_cast<float>(q & ((1u << kBits) - 1)) / kHalf - 1, 1.f);
}

}  // namespace

std::string_view describe(PhotonClass c) { return kClassTexts[static_cast<std::size_t>(c)]; }

PackedDirection::PackedDirection(const Vec3& unit)
    : bits_(packOctahedron<16>(unit.x, unit.y, unit.z)) {}

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
  return {p, power, PackedDirection(wi),
          static_cast<std::uint32_t>(c) | packOctahedron<12>(n.x, n.y, n.z) << 8};
}

}  // namespace brume
