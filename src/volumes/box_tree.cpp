// SPDX-License-Identifier: Apache-2.0
#include "volumes/box_tree.h"

#include <algorithm>
#include <numeric>

namespace brume {

BoxTree::BoxTree(std::span<const Bounds3> boxes) : order_(boxes.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  if (!boxes.empty()) build(boxes, 0, static_cast<std::uint32_t>(boxes.size()));
}

void BoxTree::build(std::span<const Bounds3> boxes, std::uint32_t begin, std::uint32_t end) {
  const auto node = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Bounds3 bounds, centres;
  for (std::uint32_t i = begin; i < end; ++i) {
    bounds.extend(boxes[order_[i]]);
    centres.extend(boxes[order_[i]].center());
  }
  const Vec3 slack(kSlack * maxComponent(max(abs(bounds.lo), abs(bounds.hi))));
  nodes_[node].bounds = {bounds.lo - slack, bounds.hi + slack};
  if (end - begin <= kLeafSize) {
    nodes_[node].count = end - begin;
    nodes_[node].at = begin;
    return;
  }
  const Vec3 d = centres.diagonal();
  const int axis = d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     return boxes[a].center()[axis] < boxes[b].center()[axis];
                   });
  build(boxes, begin, middle);
  nodes_[node].at = static_cast<std::uint32_t>(nodes_.size());
  build(boxes, middle, end);
}

}  // namespace brume
