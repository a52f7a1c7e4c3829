// SPDX-License-Identifier: Apache-2.0
// What is in a photon file: `brume photons`.
#pragma once

#include <string>

namespace brume {

struct PhotonReportOptions {
  std::string file;  ///< photon file
  std::string ply;   ///< point cloud to write; empty: none
};

/// Version, size, origin and bounds, and counts, paths and power of each class, as text. Writes the
/// point cloud: binary little-endian PLY with scene-space positions, colour, class, power and the
/// direction towards where the light came from. Throws SceneError when the file is not sound.
std::string reportPhotons(const PhotonReportOptions& options);

}  // namespace brume
