// SPDX-License-Identifier: Apache-2.0
// The partition of light (DESIGN.md 6): every path from a light to the camera belongs to one
// component, so that the components add up to the image.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "core/rgb.h"

namespace brume {

/// Read from the camera: mirrors and glass in front of the first other scattering do not count. L
/// a light or the emission of a medium, E the camera, S a specular scattering, D another one at a
/// surface, V one in a medium.
enum class PathComponent : std::uint8_t {
  Emission,         ///< L S* E
  SurfaceDirect,    ///< L D S* E
  SurfaceCaustic,   ///< L S+ D S* E
  SurfaceIndirect,  ///< L ... D S* E with a D or V between
  VolumeSingle,     ///< L V S* E
  VolumeCaustic,    ///< L S+ V S* E
  VolumeMultiple    ///< L ... V S* E with a D or V between
};
inline constexpr int kPathComponents = 7;
/// "emission", "surface_direct" ...: the layer's name in image files.
std::string_view componentName(PathComponent component);

/// What happens at a vertex of a path.
enum class Scattering : std::uint8_t { Specular, Surface, Medium };

/// The component of light that arrives over one more vertex. A path walked from the camera begins
/// with Emission. A path walked from the light begins with SurfaceDirect, the component where it is
/// gathered at a surface; inMedium() turns it into the one where it is gathered in a medium.
constexpr PathComponent after(PathComponent before, Scattering scattering) {
  using enum PathComponent;
  constexpr PathComponent kTable[kPathComponents][3] = {
      // Specular, Surface, Medium
      {Emission, SurfaceDirect, VolumeSingle},              // Emission
      {SurfaceCaustic, SurfaceIndirect, SurfaceIndirect},   // SurfaceDirect
      {SurfaceCaustic, SurfaceIndirect, SurfaceIndirect},   // SurfaceCaustic
      {SurfaceIndirect, SurfaceIndirect, SurfaceIndirect},  // SurfaceIndirect
      {VolumeCaustic, VolumeMultiple, VolumeMultiple},      // VolumeSingle
      {VolumeCaustic, VolumeMultiple, VolumeMultiple},      // VolumeCaustic
      {VolumeMultiple, VolumeMultiple, VolumeMultiple},     // VolumeMultiple
  };
  return kTable[static_cast<int>(before)][static_cast<int>(scattering)];
}
/// The component of the same light gathered in a medium in place of a surface.
constexpr PathComponent inMedium(PathComponent atSurface) {
  using enum PathComponent;
  return atSurface == SurfaceDirect     ? VolumeSingle
         : atSurface == SurfaceCaustic  ? VolumeCaustic
         : atSurface == SurfaceIndirect ? VolumeMultiple
                                        : atSurface;
}

/// Radiance of one camera sample by component [W m^-2 sr^-1].
class ComponentRadiance {
 public:
  void add(PathComponent component, const Rgb& L) { L_[static_cast<std::size_t>(component)] += L; }
  const Rgb& operator[](PathComponent component) const {
    return L_[static_cast<std::size_t>(component)];
  }
  /// Their sum: the radiance of the sample.
  Rgb total() const {
    Rgb sum;
    for (const Rgb& L : L_) sum += L;
    return sum;
  }

 private:
  std::array<Rgb, kPathComponents> L_{};
};

}  // namespace brume
