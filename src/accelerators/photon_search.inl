// SPDX-License-Identifier: Apache-2.0
// Searches in a PhotonTreeView, included once for each kind of Lanes (lanes.h).

using Node = PhotonTreeView::Node;
using Block = PhotonTreeView::Block;
using Search = PhotonKdTree::Search;
using Found = PhotonKdTree::Found;

struct Position {
  Lanes x, y, z;
};

/// Squared distances to the boxes of the children. Rounding is monotone, so none is larger than
/// that of a point inside, computed by pointDistances2: nothing is missed, without any slack.
BRUME_KERNEL inline Lanes boxDistances2(const Node& node, const Position& p) {
  const Lanes zero = Lanes::all(0);
  const Lanes dx =
      max(max(Lanes::load(node.lo[0].data()) - p.x, p.x - Lanes::load(node.hi[0].data())), zero);
  const Lanes dy =
      max(max(Lanes::load(node.lo[1].data()) - p.y, p.y - Lanes::load(node.hi[1].data())), zero);
  const Lanes dz =
      max(max(Lanes::load(node.lo[2].data()) - p.z, p.z - Lanes::load(node.hi[2].data())), zero);
  return dx * dx + dy * dy + dz * dz;
}

BRUME_KERNEL inline Lanes pointDistances2(const Block& block, const Position& p) {
  const Lanes dx = p.x - Lanes::load(block.x.data()), dy = p.y - Lanes::load(block.y.data()),
              dz = p.z - Lanes::load(block.z.data());
  return dx * dx + dy * dy + dz * dz;
}

/// Puts x at the front of a max-heap, whose front it replaces.
BRUME_KERNEL inline void replaceFront(Neighbour* heap, std::size_t size, Neighbour x) {
  std::size_t hole = 0;
  for (std::size_t child = 1; child < size; child = 2 * hole + 1) {
    if (child + 1 < size && heap[child] < heap[child + 1]) ++child;
    if (!(x < heap[child])) break;
    heap[hole] = heap[child];
    hole = child;
  }
  heap[hole] = x;
}

/// The nearest found so far: a list until it is full, a max-heap from then on.
struct Nearest {
  Neighbour* found;
  std::size_t capacity;
  Neighbour bound;  ///< only what sorts before it is of interest
  std::size_t size = 0;

  BRUME_KERNEL void add(Neighbour x) {
    if (!(x < bound)) return;
    if (size < capacity) {
      found[size++] = x;
      if (size < capacity) return;
      std::make_heap(found, found + size);
    } else {
      replaceFront(found, size, x);
    }
    bound = found[0];
  }
};

BRUME_KERNEL std::size_t nearest(const PhotonTreeView& tree, const Vec3& at, Nearest nearest) {
  // Nodes to visit, the nearest on top. A node sorts by its distance and its first point, so that
  // among equal distances the lowest index comes first and the rest is cut off.
  struct Entry {
    Neighbour key;  // squared distance and index of the first point
    std::uint32_t node, level;
  };
  std::array<Entry, 7 * PhotonTreeView::kMaxLevels + 1> stack;
  std::size_t size = 0;
  const Position p{Lanes::all(at.x), Lanes::all(at.y), Lanes::all(at.z)};
  stack[size++] = {Neighbour(0, 0), 0, tree.top};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (!(entry.key < nearest.bound)) continue;
    std::array<float, kLanes> distances2;
    if (entry.level == 0) {
      const Lanes d2 = pointDistances2(tree.blocks[entry.node], p);
      LaneMask mask = lessEqual(d2, Lanes::all(nearest.bound.distance2()));
      d2.store(distances2.data());
      for (; mask != 0; mask &= mask - 1) {
        const auto i = static_cast<std::uint32_t>(std::countr_zero(mask));
        nearest.add(Neighbour(distances2[i], entry.node * std::uint32_t{kLanes} + i));
      }
      continue;
    }
    const Lanes d2 = boxDistances2(tree.levels[entry.level][entry.node], p);
    LaneMask mask = lessEqual(d2, Lanes::all(nearest.bound.distance2()));
    d2.store(distances2.data());
    const std::size_t base = size;
    for (; mask != 0; mask &= mask - 1) {
      const auto i = static_cast<std::uint32_t>(std::countr_zero(mask));
      const std::uint32_t child = entry.node * std::uint32_t{kLanes} + i, level = entry.level - 1;
      const Entry next{Neighbour(distances2[i], child << 3 * (level + 1)), child, level};
      std::size_t to = size++;
      for (; to > base && stack[to - 1].key < next.key; --to) stack[to] = stack[to - 1];
      stack[to] = next;
    }
  }
  if (nearest.size < nearest.capacity) std::make_heap(nearest.found, nearest.found + nearest.size);
  return nearest.size;
}

/// Points of a block whose lanes are in the mask.
BRUME_KERNEL inline void append(Found& found, std::size_t& count, std::uint32_t block,
                                LaneMask mask, const Lanes& d2) {
  compressIndices(block * std::uint32_t{kLanes}, mask, found.indices.data() + count);
  compress(d2, mask, found.distances2.data() + count);
  count += static_cast<std::size_t>(std::popcount(mask));
}

/// Goes on with a search until `found` may be full or nothing is left.
BRUME_KERNEL std::size_t searchBall(const PhotonTreeView& tree, Search& search, const Vec3& at,
                                    float radius2, Found& found) {
  const Position p{Lanes::all(at.x), Lanes::all(at.y), Lanes::all(at.z)};
  const Lanes limit = Lanes::all(radius2);
  std::size_t count = 0;
  while (search.size > 0 && count <= PhotonKdTree::kBatch - PhotonKdTree::kBatchMost) {
    const Search::Entry entry = search.stack[--search.size];
    LaneMask mask = less(boxDistances2(tree.levels[entry.level][entry.node], p), limit);
    for (; mask != 0; mask &= mask - 1) {
      const std::uint32_t child =
          entry.node * std::uint32_t{kLanes} + static_cast<std::uint32_t>(std::countr_zero(mask));
      if (entry.level > 1) {
        search.stack[search.size++] = {child, entry.level - 1};
        continue;
      }
      const Lanes d2 = pointDistances2(tree.blocks[child], p);
      append(found, count, child, less(d2, limit), d2);
    }
  }
  return count;
}
