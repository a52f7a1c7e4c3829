// SPDX-License-Identifier: Apache-2.0
// Point searches in the photon kd-tree, for each instruction set.
#include "accelerators/photon_kdtree.h"

namespace brume {
namespace {

#define BRUME_KERNELS "accelerators/photon_search.inl"
#include "core/both_lanes.inl"

}  // namespace

PhotonKdTree::Search::Search(const PhotonTreeView& tree) {
  if (tree.top > 0) stack[size++] = {0, tree.top};
}

std::size_t PhotonKdTree::nearest(const Vec3& p, std::span<Neighbour> found,
                                  float maxRadius) const {
  if (size_ == 0 || found.empty()) return 0;
  const Neighbour bound(maxRadius * maxRadius, 0);
  if (hasAvx2()) return avx2::nearest(view_, p, {found.data(), found.size(), bound});
  return generic::nearest(view_, p, {found.data(), found.size(), bound});
}

std::size_t PhotonKdTree::searchBall(Search& search, const Vec3& p, float radius2,
                                     Found& found) const {
  if (hasAvx2()) return avx2::searchBall(view_, search, p, radius2, found);
  return generic::searchBall(view_, search, p, radius2, found);
}

}  // namespace brume
