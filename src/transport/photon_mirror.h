// SPDX-License-Identifier: Apache-2.0
// Photons continued across the outer faces of media.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/volume.h"

namespace brume {

/// Near a face of a medium part of a kernel lies where no photons are, and an estimate is too dark
/// by that part. Mirror images of the photons on the other side fill it (Silverman 1986, 2.10:
/// reflection at boundaries). The density of photons falls towards a face as if it vanished at the
/// extrapolation length z0 = 2 / (3 sigma_t (1 - g)) behind it (diffusion theory, Ishimaru 1978,
/// 9), so an image x behind the face has the power
///   alpha exp(-2 x / z0)     ~ alpha (1 - x/z0) / (1 + x/z0)
/// which continues that density to first order, and is a plain mirror image in thin media. An image
/// only counts through kernels: beams and points of lookup stay inside. For a scene with one box of
/// medium; several may overlap or touch, and are left as they are. Test: photon_mirror_test.
class PhotonMirror {
 public:
  explicit PhotonMirror(const Volume& volume)
      : volume_(volume), forward_(volume.henyeyGreenstein().value_or(0)) {
    std::vector<MediumBox> boxes;
    volume.appendBoxes(boxes);
    if (boxes.size() == 1) box_ = boxes.front();
  }
  bool isEmpty() const { return !box_; }

  /// Calls add(image, share) for each mirror image of p that a kernel of this radius can reach from
  /// inside of the medium; share: of the photon's power.
  template <class Add>
  void forEachImage(const Vec3& p, float radius, Add&& add) const {
    if (!box_) return;
    std::array<Image, kMostImages> images;
    const std::size_t count = imagesOf(p, radius, images);
    if (count < 2) return;
    const Rgb rate = volume_.at(p).sigma_t() * (3 * (1 - forward_));  // 2 / z0
    for (std::size_t i = 1; i < count; ++i)
      add(images[i].p, exp(-rate * static_cast<float>(images[i].depth)));
  }

 private:
  /// The photon itself is the first, at distance 0.
  struct Image {
    Vec3 p{0};
    double distance2 = 0;  // from the medium
    double depth = 0;      // behind its faces, all together
  };
  static constexpr std::size_t kMostImages = 27;
  std::size_t imagesOf(const Vec3& p, float radius, std::array<Image, kMostImages>& images) const;

  const Volume& volume_;
  float forward_;  // mean cosine of scattering, where it is one
  std::optional<MediumBox> box_;
};

}  // namespace brume
