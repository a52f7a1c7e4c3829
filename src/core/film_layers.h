// SPDX-License-Identifier: Apache-2.0
// What a film holds beside colour when layers are asked for.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "core/math.h"
#include "core/path_component.h"

namespace brume {

/// What one camera sample adds to the layers, beside its radiance.
struct LayerSample {
  /// Radiance by component; none when the integrator does not tell them apart.
  std::optional<ComponentRadiance> components;
  /// Of the media up to the first surface, or through the scene.
  Rgb transmittance{1.f};
  bool hasHit = false;  ///< whether the ray meets a surface; what follows is 0 without
  float depth = 0;      ///< distance to it from the ray's origin [scene length]
  Vec3 normal{0};       ///< shading normal, unit, scene space
  Rgb albedo;           ///< hemispherical-directional reflectance of all lobes
};

/// Channels of the layers, in the order of layerValues().
inline constexpr std::size_t kComponentChannels = 3 * kPathComponents;
inline constexpr std::size_t kGeometryChannels = 3 + 3 + 3 + 1;
inline constexpr std::size_t kLayerChannels = kComponentChannels + kGeometryChannels;
/// "emission.R" ... "volume_multiple.B", "transmittance.R" ..., "albedo.R" ..., "normal.X" ...,
/// "depth.Z".
const std::array<std::string, kLayerChannels>& layerChannelNames();
/// Depth, the only layer that is a mean over the samples that meet a surface, comes last.
inline constexpr std::size_t kDepthChannel = kLayerChannels - 1;
std::array<float, kLayerChannels> layerValues(const LayerSample& sample);

}  // namespace brume
