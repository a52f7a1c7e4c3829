// SPDX-License-Identifier: Apache-2.0
#include "accelerators/photon_bvh.h"

#include "accelerators/photon_ball.h"
#include "core/error.h"

namespace brume {
namespace {

using LaneRow = PhotonBvhView::LaneRow;

#define BRUME_KERNELS "accelerators/photon_beam_search.inl"
#include "core/both_lanes.inl"

/// Blocks per task.
constexpr std::int64_t kBlocksPerTask = 64;

template <class F>
void forEachBlock(std::size_t count, F&& f) {
  forEachChunk(static_cast<std::int64_t>(count), kBlocksPerTask,
               [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                 for (auto i = begin; i < end; ++i) f(static_cast<std::size_t>(i));
               });
}

float largest(const LaneRow& row) { return *std::max_element(row.begin(), row.end()); }

/// Whether the radii of level 1 say all: equal in each block, and the squares of their roots.
bool areOfBlocks(std::span<const float> radii2) {
  for (std::size_t i = 0; i < radii2.size(); ++i)
    if (radii2[i] != radii2[i / kLanes * kLanes] || sqr(std::sqrt(radii2[i])) != radii2[i])
      return false;
  return true;
}

}  // namespace

PhotonBvh::PhotonBvh(const PhotonKdTree& tree, float radius) {
  BRUME_CHECK(radius >= 0);
  view_.tree = tree.view();
  view_.radius2 = radius * radius;
}

PhotonBvh::PhotonBvh(const PhotonKdTree& tree, std::span<const float> radii2) {
  BRUME_CHECK(radii2.size() == tree.size());
  view_.tree = tree.view();
  if (tree.size() == 0) return;

  radii2_.resize((radii2.size() + kLanes - 1) / kLanes);
  forEachBlock(radii2_.size(), [&](std::size_t b) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const std::size_t at = b * kLanes + i;
      radii2_[b][i] = at < radii2.size() ? radii2[at] : 0.f;
    }
  });

  // The largest radii, from the blocks up.
  std::vector<std::size_t> counts;
  for (std::size_t n = radii2_.size(); counts.size() < view_.tree.top;)
    counts.push_back(n = (n + kLanes - 1) / kLanes);
  std::size_t total = 0;
  for (const std::size_t n : counts) total += n;
  childRadii_.resize(total);
  std::span<const LaneRow> below = radii2_;
  LaneRow* level = childRadii_.data();
  for (std::size_t l = 0; l < counts.size(); ++l) {
    forEachBlock(counts[l], [&](std::size_t n) {
      for (std::size_t i = 0; i < kLanes; ++i) {
        const std::size_t child = n * kLanes + i;
        const float most = child < below.size() ? largest(below[child]) : 0.f;
        level[n][i] = l == 0 ? std::sqrt(most) : most;
      }
    });
    view_.childRadii[l + 1] = level;
    below = {level, counts[l]};
    level += counts[l];
  }
  if (areOfBlocks(radii2)) {
    view_.kind = PhotonBvhView::Radii::OfBlocks;
    radii2_ = {};
  } else {
    view_.kind = PhotonBvhView::Radii::Each;
    view_.radii2 = radii2_.data();
  }
}

std::size_t PhotonBvh::searchBeam(PhotonKdTree::Search& search, const BeamQuery& beam,
                                  Found& found) const {
  if (hasAvx2()) return avx2::searchBeam(view_, search, beam, found);
  return generic::searchBeam(view_, search, beam, found);
}

std::vector<float> adaptiveRadii2(const PhotonKdTree& tree, std::size_t k) {
  BRUME_CHECK(k > 0);
  std::vector<float> radii2(tree.size());
  // The least: what the precision of positions can tell apart.
  const float least = std::max(kBeamSlack * tree.view().maxCoordinate, 1e-15f);
  forEachBlock((tree.size() + kLanes - 1) / kLanes, [&](std::size_t block) {
    thread_local BallSearch search;  // reused, so that its memory and last radius are
    const std::size_t first = block * kLanes, end = std::min(first + kLanes, tree.size());
    Vec3d sum(0);
    for (std::size_t i = first; i < end; ++i) sum += Vec3d(tree.point(i));
    const Vec3 middle(sum / static_cast<double>(end - first));
    const std::size_t n = std::min(k, tree.size());
    const float missing = std::cbrt(static_cast<float>(k) / static_cast<float>(n));
    const float farthest = std::sqrt(search.radius2OfNearest(tree, middle, k));
    const float radius = std::max(farthest * missing, least);
    for (std::size_t i = first; i < end; ++i) radii2[i] = radius * radius;
  });
  return radii2;
}

}  // namespace brume
