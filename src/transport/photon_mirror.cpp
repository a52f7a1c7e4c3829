// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_mirror.h"

namespace brume {

std::size_t PhotonMirror::imagesOf(const Vec3& p, float radius,
                                   std::array<Image, kMostImages>& images) const {
  std::array<double, 6> depth;  // below each face
  for (std::size_t f = 0; f < 6; ++f) {
    depth[f] = box_->offset[f] - dot(box_->normal[f], Vec3d(p));
    if (depth[f] < 0) return 0;
  }
  // Axis by axis: what is there so far, and its images in the two faces.
  images[0] = {p, 0, 0};
  std::size_t count = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t before = count;
    for (std::size_t f = 2 * axis; f < 2 * axis + 2; ++f) {
      if (!(depth[f] < double{radius})) continue;
      for (std::size_t i = 0; i < before; ++i) {
        const double distance2 = images[i].distance2 + sqr(depth[f]);
        if (distance2 < sqr(double{radius}))
          images[count++] = {Vec3(Vec3d(images[i].p) + 2 * depth[f] * box_->normal[f]), distance2,
                             images[i].depth + depth[f]};
      }
    }
  }
  return count;
}

}  // namespace brume
