// SPDX-License-Identifier: Apache-2.0
// Photons: samples of the flux of light, as photon maps and beams take them.
//
// A light path carries power alpha [W]. At every collision in a medium, and at every surface hit,
// it deposits a Photon with the power that arrives, before albedo or BSDF. Collisions are drawn
// with density sigma_t Tr, so with alpha divided by the number of emitted paths
//   E[sum alpha_i delta(x - x_i)] = sigma_t * fluence          in media [W m^-3]
//   E[sum alpha_i delta(x - x_i)] = irradiance                 on surfaces [W m^-2]
// Positions are in render space.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/math.h"
#include "core/rgb.h"

namespace brume {

/// What a photon has met on its way: its place in the partition of all light (DESIGN.md 6).
enum class PhotonClass : std::uint8_t {
  SurfaceDirect,      ///< on a surface, straight from the light
  SurfaceCaustic,     ///< on a surface, by specular surfaces only
  SurfaceIndirect,    ///< on a surface, all else
  VolumeUnscattered,  ///< in a medium, straight from the light
  VolumeCaustic,      ///< in a medium, by specular surfaces only
  VolumeMultiple,     ///< in a medium, all else
  Count
};
inline constexpr std::size_t kPhotonClasses = static_cast<std::size_t>(PhotonClass::Count);
/// Words that follow "photons": "on surfaces, straight from the lights" and so on.
std::string_view describe(PhotonClass c);

/// A set of classes, as bits.
class PhotonClasses {
 public:
  constexpr PhotonClasses() = default;
  constexpr PhotonClasses(PhotonClass c) : bits_(1u << static_cast<unsigned>(c)) {}
  constexpr PhotonClasses operator|(PhotonClasses o) const { return fromBits(bits_ | o.bits_); }
  constexpr PhotonClasses operator&(PhotonClasses o) const { return fromBits(bits_ & o.bits_); }
  constexpr bool contains(PhotonClass c) const { return !(*this & c).isEmpty(); }
  constexpr bool isEmpty() const { return bits_ == 0; }
  constexpr std::uint32_t bits() const { return bits_; }
  static constexpr PhotonClasses fromBits(std::uint32_t bits) {
    PhotonClasses c;
    c.bits_ = bits;
    return c;
  }

 private:
  std::uint32_t bits_ = 0;
};
constexpr PhotonClasses operator|(PhotonClass a, PhotonClass b) {
  return PhotonClasses(a) | PhotonClasses(b);
}
inline constexpr PhotonClasses kSurfacePhotons =
    PhotonClass::SurfaceDirect | PhotonClass::SurfaceCaustic | PhotonClass::SurfaceIndirect;
inline constexpr PhotonClasses kVolumePhotons =
    PhotonClass::VolumeUnscattered | PhotonClass::VolumeCaustic | PhotonClass::VolumeMultiple;

/// A unit vector in 32 bits: octahedral map, 16 bits per axis; off by at most 7e-5 rad.
/// Source: Cigolle et al. 2014, A Survey of Efficient Representations for Independent Unit Vectors.
class PackedDirection {
 public:
  PackedDirection() = default;
  explicit PackedDirection(const Vec3& unit);
  Vec3 unpack() const;
  std::uint32_t bits() const { return bits_; }
  static PackedDirection fromBits(std::uint32_t bits) {
    PackedDirection d;
    d.bits_ = bits;
    return d;
  }

 private:
  std::uint32_t bits_ = 0;
};

/// One deposit. 32 bytes.
struct Photon {
  Vec3 p{0};
  Rgb power;           ///< alpha, what arrives [W]
  PackedDirection wi;  ///< to where the light comes from
  /// Bits 0..7: PhotonClass. Bits 8..31: geometric normal of the surface, octahedral with 12 bits
  /// per axis (surface photons only).
  std::uint32_t bits = 0;

  PhotonClass photonClass() const { return static_cast<PhotonClass>(bits & 0xffu); }
  bool isOnSurface() const { return kSurfacePhotons.contains(photonClass()); }
  /// Geometric normal, off by at most 1e-3 rad.
  Vec3 normal() const;

  static Photon inMedium(const Vec3& p, const Vec3& wi, const Rgb& power, PhotonClass c);
  static Photon onSurface(const Vec3& p, const Vec3& wi, const Vec3& n, const Rgb& power,
                          PhotonClass c);
};
static_assert(sizeof(Photon) == 32);

}  // namespace brume
