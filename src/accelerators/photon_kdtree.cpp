// SPDX-License-Identifier: Apache-2.0
#include "accelerators/photon_kdtree.h"

#include "accelerators/kd_order.h"
#include "core/error.h"

namespace brume {
namespace {

using Block = PhotonTreeView::Block;
using Node = PhotonTreeView::Node;

std::size_t divideUp(std::size_t a, std::size_t b) { return (a + b - 1) / b; }

/// Blocks or nodes per task.
constexpr std::int64_t kBoxesPerTask = 512;

void setChild(Node& node, std::size_t child, const Bounds3& box) {
  for (int axis = 0; axis < 3; ++axis) {
    node.lo[static_cast<std::size_t>(axis)][child] = box.lo[axis];
    node.hi[static_cast<std::size_t>(axis)][child] = box.hi[axis];
  }
}

Bounds3 boxOf(const Block& block, std::size_t points) {
  Bounds3 box;
  for (std::size_t i = 0; i < points; ++i) box.extend(Vec3(block.x[i], block.y[i], block.z[i]));
  return box;
}

/// Absent children are inverted and do not count.
Bounds3 boxOf(const Node& node) {
  Bounds3 box;
  for (std::size_t i = 0; i < kLanes; ++i) {
    box.lo = min(box.lo, Vec3(node.lo[0][i], node.lo[1][i], node.lo[2][i]));
    box.hi = max(box.hi, Vec3(node.hi[0][i], node.hi[1][i], node.hi[2][i]));
  }
  return box;
}

void checkFinite(StridedPoints points) {
  forEachChunk(static_cast<std::int64_t>(points.size()), 1 << 16,
               [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                 for (auto i = begin; i < end; ++i)
                   BRUME_CHECK(isFinite(points[static_cast<std::size_t>(i)]));
               });
}

}  // namespace

PhotonKdTree::PhotonKdTree(StridedPoints points) : size_(points.size()) {
  BRUME_CHECK(size_ < (std::size_t{1} << 32) - kLanes);
  checkFinite(points);
  order_ = kdOrder(points);

  // The points, block by block.
  blocks_.resize(divideUp(size_, kLanes));
  forEachChunk(static_cast<std::int64_t>(blocks_.size()), kBoxesPerTask,
               [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                 for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end);
                      ++b)
                   for (std::size_t i = 0; i < kLanes; ++i) {
                     const std::size_t at = b * kLanes + i;
                     const Vec3 p = at < size_ ? points[order_[at]]
                                               : Vec3(std::numeric_limits<float>::quiet_NaN());
                     blocks_[b].x[i] = p.x;
                     blocks_[b].y[i] = p.y;
                     blocks_[b].z[i] = p.z;
                   }
               });
  computeBoxes();
}

/// All levels, from the blocks up.
void PhotonKdTree::computeBoxes() {
  std::vector<std::size_t> counts;  // of nodes by level; first those of level 1
  for (std::size_t n = blocks_.size(); n > 0 && (counts.empty() || n > 1);)
    counts.push_back(n = divideUp(n, kLanes));
  std::size_t total = 0;
  for (const std::size_t n : counts) total += n;
  nodes_.resize(total);

  view_.blocks = blocks_.data();
  view_.top = static_cast<std::uint32_t>(counts.size());
  Node* level = nodes_.data();
  const Node* below = nullptr;
  std::size_t belowCount = blocks_.size();
  for (std::size_t l = 0; l < counts.size(); ++l) {
    forEachChunk(static_cast<std::int64_t>(counts[l]), kBoxesPerTask,
                 [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                   for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end);
                        ++n)
                     for (std::size_t i = 0; i < kLanes; ++i) {
                       const std::size_t child = n * kLanes + i;
                       if (child >= belowCount)
                         setChild(level[n], i, Bounds3{});
                       else if (below != nullptr)
                         setChild(level[n], i, boxOf(below[child]));
                       else
                         setChild(level[n], i,
                                  boxOf(blocks_[child], std::min(kLanes, size_ - child * kLanes)));
                     }
                 });
    view_.levels[l + 1] = below = level;
    belowCount = counts[l];
    level += counts[l];
  }
  if (below == nullptr) return;
  bounds_ = boxOf(*below);
  view_.maxCoordinate = std::max(maxComponent(abs(bounds_.lo)), maxComponent(abs(bounds_.hi)));
}

Vec3 PhotonKdTree::point(std::size_t i) const {
  const Block& block = blocks_[i / kLanes];
  return {block.x[i % kLanes], block.y[i % kLanes], block.z[i % kLanes]};
}

std::size_t PhotonKdTree::memoryBytes() const {
  return blocks_.size() * sizeof(Block) + nodes_.size() * sizeof(Node);
}

}  // namespace brume
