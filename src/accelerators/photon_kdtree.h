// SPDX-License-Identifier: Apache-2.0
// A kd-tree over points, for photon maps: k nearest, all within a radius; PhotonBvh adds beams.
//
// Layout. The points stand in blocks of 8, in structure-of-arrays form, in the order of the leaves
// of a kd-tree whose splits lie at whole blocks. 8 neighbouring blocks make a node of level 1, 8
// neighbouring nodes of a level one of the next; a node holds the boxes of its children, 8 in one
// vector operation. All nodes but the last of each level are full, so children are found by index:
// there are no pointers. Memory: 12 bytes per point and 3.5 for the boxes.
//
// Points are known by their place in this order; order() tells which one of the given points stands
// where, so that the caller can lay what else belongs to a photon in the same order (inOrder) and
// drop its position. Everything is the same for any number of threads.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/lanes.h"
#include "core/math.h"
#include "core/parallel.h"

namespace brume {

/// Positions that stand anywhere in memory at equal distances: the Vec3 of a larger struct.
class StridedPoints {
 public:
  StridedPoints() = default;
  StridedPoints(const Vec3* first, std::size_t count, std::size_t bytesApart = sizeof(Vec3))
      : first_(reinterpret_cast<const std::byte*>(first)), count_(count), bytesApart_(bytesApart) {}
  StridedPoints(std::span<const Vec3> points) : StridedPoints(points.data(), points.size()) {}

  std::size_t size() const { return count_; }
  const Vec3& operator[](std::size_t i) const {
    return *reinterpret_cast<const Vec3*>(first_ + i * bytesApart_);
  }

 private:
  const std::byte* first_ = nullptr;
  std::size_t count_ = 0, bytesApart_ = sizeof(Vec3);
};

/// A point that was found; sorts by distance, then by index.
class Neighbour {
 public:
  Neighbour() = default;
  Neighbour(float distance2, std::uint32_t index)
      : key_(std::uint64_t{std::bit_cast<std::uint32_t>(distance2)} << 32 | index) {}
  std::uint32_t index() const { return static_cast<std::uint32_t>(key_); }
  float distance2() const { return std::bit_cast<float>(static_cast<std::uint32_t>(key_ >> 32)); }
  friend bool operator<(const Neighbour& a, const Neighbour& b) { return a.key_ < b.key_; }
  friend bool operator==(const Neighbour&, const Neighbour&) = default;

 private:
  std::uint64_t key_ = 0;  // non-negative floats sort like their bits
};

/// What the kernels see of the tree.
struct PhotonTreeView {
  struct alignas(32) Block {
    std::array<float, kLanes> x, y, z;  ///< NaN behind the last point
  };
  struct alignas(64) Node {
    std::array<std::array<float, kLanes>, 3> lo, hi;  ///< infinite and inverted behind the last
  };
  static constexpr std::uint32_t kMaxLevels = 11;  // 8^11 > 2^32

  const Block* blocks = nullptr;
  std::array<const Node*, kMaxLevels> levels{};  ///< nodes by level, from 1
  std::uint32_t top = 0;                         ///< level of the root; 0: no points
  float maxCoordinate = 0;                       ///< largest absolute value
};

/// See the head of this file. Distances are computed in float as dx dx + dy dy + dz dz, dx = p.x -
/// x; points so far apart that this overflows do not find each other.
class PhotonKdTree {
 public:
  /// Points must be finite (BRUME_CHECK) and fewer than 2^32 - 8.
  explicit PhotonKdTree(StridedPoints points);
  PhotonKdTree(PhotonKdTree&&) = default;
  PhotonKdTree& operator=(PhotonKdTree&&) = default;

  std::size_t size() const { return size_; }
  Vec3 point(std::size_t i) const;
  /// order()[i]: the index of point i among those given.
  std::span<const std::uint32_t> order() const { return order_; }
  /// Frees order(), once everything is laid in it.
  void dropOrder() { order_ = {}; }
  const Bounds3& bounds() const { return bounds_; }
  /// Of the tree, without order().
  std::size_t memoryBytes() const;
  const PhotonTreeView& view() const { return view_; }

  /// The `found.size()` nearest points with distance below maxRadius, or all when these are fewer.
  /// Returns how many there are; they stand in `found` as a heap, the farthest in front (std::sort
  /// sorts them). Equal distances: the lower index wins.
  std::size_t nearest(const Vec3& p, std::span<Neighbour> found, float maxRadius = kInfinity) const;

  /// Calls f(index, distance2) for each point with distance2 < radius2, each once, in an order that
  /// depends on tree and query alone.
  template <class F>
  void forEachWithin(const Vec3& p, float radius2, F&& f) const {
    forEachBatchWithin(p, radius2, [&](const Found& batch, std::size_t n) {
      for (std::size_t i = 0; i < n; ++i) f(batch.indices[i], batch.distances2[i]);
      return true;
    });
  }

  /// Nodes that a search has still to visit.
  struct Search {
    explicit Search(const PhotonTreeView& tree);
    struct Entry {
      std::uint32_t node, level;
    };
    std::array<Entry, 7 * PhotonTreeView::kMaxLevels + 1> stack;
    std::size_t size = 0;
  };
  /// A search stops when a node of level 1 may no longer fit; stores write whole vectors.
  static constexpr std::size_t kBatch = 256, kBatchMost = kLanes * kLanes;
  struct Found {
    std::array<std::uint32_t, kBatch + kLanes> indices;
    std::array<float, kBatch + kLanes> distances2;
  };
  /// forEachWithin with many points at a time: f(found, count) returns whether to go on.
  template <class F>
  void forEachBatchWithin(const Vec3& p, float radius2, F&& f) const {
    Search search(view_);
    Found batch;
    while (const std::size_t n = searchBall(search, p, radius2, batch))
      if (!f(batch, n)) return;
  }

 private:
  std::size_t searchBall(Search& search, const Vec3& p, float radius2, Found& found) const;
  void computeBoxes();

  std::size_t size_ = 0;
  std::vector<PhotonTreeView::Block> blocks_;
  std::vector<PhotonTreeView::Node> nodes_;  // level 1 first
  std::vector<std::uint32_t> order_;
  Bounds3 bounds_;
  PhotonTreeView view_;
};

/// The values in the order of a tree.
template <class T>
std::vector<T> inOrder(std::span<const T> values, std::span<const std::uint32_t> order) {
  std::vector<T> result(order.size());
  forEachChunk(static_cast<std::int64_t>(order.size()), 1 << 14,
               [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end);
                      ++i)
                   result[i] = values[order[i]];
               });
  return result;
}

}  // namespace brume
