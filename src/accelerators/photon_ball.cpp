// SPDX-License-Identifier: Apache-2.0
#include "accelerators/photon_ball.h"

#include "core/error.h"

namespace brume {
namespace {

/// Squares of the factors by which a radius is taken larger than the last one: so far neighbouring
/// searches differ seldom; and by which it grows when it was too small.
constexpr float kNextRadius2 = 1.25f, kGrowth2 = 1.6f;
constexpr int kGuesses = 2;
/// Times k: with more points a guess is too large to be of use.
constexpr std::size_t kMostCandidates = 6;
constexpr std::size_t kAll = ~std::size_t{0};

}  // namespace

/// False: there are more than `most`.
bool BallSearch::collect(const PhotonKdTree& tree, const Vec3& p, float radius2, std::size_t most) {
  size_ = 0;
  tree.forEachBatchWithin(p, radius2, [&](const PhotonKdTree::Found& batch, std::size_t n) {
    const std::size_t room = size_ + n + kLanes;
    if (indices_.size() < room) {
      indices_.resize(2 * room);
      distances2_.resize(2 * room);
    }
    std::copy_n(batch.indices.data(), n, indices_.data() + size_);
    std::copy_n(batch.distances2.data(), n, distances2_.data() + size_);
    size_ += n;
    return size_ <= most;
  });
  return size_ <= most;
}

void BallSearch::findWithin(const PhotonKdTree& tree, const Vec3& p, float radius2) {
  collect(tree, p, radius2, kAll);
}

float BallSearch::radius2OfNearest(const PhotonKdTree& tree, const Vec3& p, std::size_t k,
                                   float maxRadius) {
  BRUME_CHECK(k > 0);
  const float limit2 = sqr(maxRadius);
  float guess2 = lastRadius2_ * kNextRadius2;
  for (int i = 0; i < kGuesses && guess2 > 0; ++i, guess2 *= kGrowth2) {
    const bool isLimit = guess2 >= limit2;
    if (!collect(tree, p, isLimit ? limit2 : guess2, kMostCandidates * k)) break;
    if (size_ < k) {
      if (isLimit) return lastRadius2_ = limit2;
      continue;
    }
    ranked_.assign(distances2_.data(), distances2_.data() + size_);
    const auto kth = ranked_.begin() + static_cast<std::ptrdiff_t>(k - 1);
    std::nth_element(ranked_.begin(), kth, ranked_.end());
    return lastRadius2_ = *kth;
  }

  // The k-th stands in front.
  nearest_.resize(k);
  const std::size_t found = tree.nearest(p, nearest_, maxRadius);
  lastRadius2_ = found < k && maxRadius < kInfinity ? limit2
                 : found > 0                        ? nearest_[0].distance2()
                                                    : 0;
  collect(tree, p, lastRadius2_, kAll);
  return lastRadius2_;
}

}  // namespace brume
