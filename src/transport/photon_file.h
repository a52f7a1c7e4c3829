// SPDX-License-Identifier: Apache-2.0
// Photon maps on disk. The format is described in docs/photon_files.md; files are the same on all
// machines.
#pragma once

#include <functional>
#include <string>

#include "core/io/file_bytes.h"
#include "transport/photon_tracer.h"

namespace brume {

/// What a photon file holds.
struct PhotonFile {
  static constexpr std::uint32_t kVersion = 1;

  PhotonSet set;
  Vec3d origin{0};         ///< scene-space position of the photons' origin (Scene::sceneOrigin)
  std::uint64_t seed = 0;  ///< with which they were traced

  /// The positions by another origin, that of the scene and camera which use them.
  void moveTo(const Vec3d& newOrigin);
};

/// Calls `write` with the pieces of the file in order.
void encodePhotonFile(const PhotonFile& file, const std::function<void(ByteSpan)>& write);
/// Throws SceneError with the reason when the bytes are foreign, truncated or changed; `name` is
/// that of the file. What is allocated is never more than the bytes themselves hold.
PhotonFile decodePhotonFile(ByteSpan bytes, const std::string& name);

/// The file appears whole or not at all.
void writePhotonFile(const std::string& path, const PhotonFile& file);
PhotonFile readPhotonFile(const std::string& path);

}  // namespace brume
