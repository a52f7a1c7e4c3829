// SPDX-License-Identifier: Apache-2.0
// Photons in balls: the k nearest as all within the radius of the k-th, which is found by selection
// among those within a guessed radius. Several times faster than keeping the nearest in order.
#pragma once

#include "accelerators/photon_kdtree.h"

namespace brume {

/// Searches one after another, best for points near each other: the last radius is the next guess,
/// and memory is kept. What is found does not depend on what was searched before. Test:
/// photon_ball_test.
class BallSearch {
 public:
  /// Finds all points nearer than the radius, in the order of the tree.
  void findWithin(const PhotonKdTree& tree, const Vec3& p, float radius2);
  /// The squared distance to the k-th nearest point, k > 0: the largest there is when fewer than k
  /// are within maxRadius = infinity, else maxRadius^2. 0 where nothing is found. The points found
  /// are then those within it, and perhaps some more.
  float radius2OfNearest(const PhotonKdTree& tree, const Vec3& p, std::size_t k,
                         float maxRadius = kInfinity);

  std::size_t size() const { return size_; }
  /// With room for whole rows of lanes.
  std::uint32_t* indices() { return indices_.data(); }
  float* distances2() { return distances2_.data(); }

 private:
  bool collect(const PhotonKdTree& tree, const Vec3& p, float radius2, std::size_t most);

  std::vector<std::uint32_t> indices_;
  std::vector<float> distances2_, ranked_;
  std::vector<Neighbour> nearest_;
  std::size_t size_ = 0;
  float lastRadius2_ = 0;
};

}  // namespace brume
