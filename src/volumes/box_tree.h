// SPDX-License-Identifier: Apache-2.0
// Which of many boxes hold a point, or may be met by a ray.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/math.h"
#include "core/ray.h"

namespace brume {

/// A binary tree of axis-aligned boxes, split at the median. Visits are calls of
/// visit(index of the box), each box once, in an order that depends on the boxes alone. Rounding
/// counts as inside: a box may be named that is just missed, none that is met is left out. Test:
/// box_tree_test.
class BoxTree {
 public:
  BoxTree() = default;
  explicit BoxTree(std::span<const Bounds3> boxes);

  template <class Visit>
  void forEachAt(const Vec3& p, Visit&& visit) const {
    search([&](const Bounds3& b) { return b.contains(p); }, visit);
  }
  template <class Visit>
  void forEachAlong(const Ray& ray, Interval range, Visit&& visit) const {
    const Vec3 inverse = Vec3(1) / ray.d;
    search([&](const Bounds3& b) { return isMet(b, ray, inverse, range); }, visit);
  }

 private:
  /// Of coordinates and distances: far above their rounding.
  static constexpr float kSlack = 1e-6f;
  static constexpr std::uint32_t kLeafSize = 2;

  /// The first child of an inner node is the next node.
  struct Node {
    Bounds3 bounds;           // a little wider than its boxes
    std::uint32_t count = 0;  // of a leaf's boxes; 0: an inner node
    std::uint32_t at = 0;     // of a leaf's first box, or of the second child
  };
  void build(std::span<const Bounds3> boxes, std::uint32_t begin, std::uint32_t end);

  static bool isMet(const Bounds3& b, const Ray& ray, const Vec3& inverse, Interval range) {
    float t0 = range.t0, t1 = range.t1;
    for (int a = 0; a < 3; ++a) {
      if (ray.d[a] == 0) {
        if (!(ray.o[a] >= b.lo[a] && ray.o[a] <= b.hi[a])) return false;
        continue;
      }
      const float toLo = (b.lo[a] - ray.o[a]) * inverse[a],
                  toHi = (b.hi[a] - ray.o[a]) * inverse[a];
      const float near = std::min(toLo, toHi), far = std::max(toLo, toHi);
      t0 = std::max(t0, near - kSlack * std::abs(near));
      t1 = std::min(t1, far + kSlack * std::abs(far));
    }
    return t0 <= t1;
  }

  /// Leaves are taken whole: what is asked of their boxes next costs no more than a test.
  template <class Meets, class Visit>
  void search(Meets&& meets, Visit&& visit) const {
    if (nodes_.empty()) return;
    std::array<std::uint32_t, 64> stack;  // splits at the median: no deeper than 33
    std::size_t size = 0;
    stack[size++] = 0;
    while (size > 0) {
      const std::uint32_t at = stack[--size];
      const Node& node = nodes_[at];
      if (!meets(node.bounds)) continue;
      if (node.count > 0) {
        for (std::uint32_t i = 0; i < node.count; ++i) visit(order_[node.at + i]);
      } else {
        stack[size++] = node.at;
        stack[size++] = at + 1;
      }
    }
  }

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;  // boxes of the leaves
};

}  // namespace brume
