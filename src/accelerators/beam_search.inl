// SPDX-License-Identifier: Apache-2.0
// Searches in a BeamTreeView, included once for each kind of Lanes (lanes.h, lanes_math.h).

BRUME_KERNEL inline Lanes load(const BeamTreeView::Row& row) { return Lanes::load(row.data()); }

/// A photon's position, the same in every lane.
struct PhotonLanes {
  Lanes x, y, z;
  BRUME_KERNEL explicit PhotonLanes(const Vec3& p)
      : x(Lanes::all(p.x)), y(Lanes::all(p.y)), z(Lanes::all(p.z)) {}
};

/// The children that may contain p: BeamFrustum::mayContain eight times.
BRUME_KERNEL inline LaneMask childrenWith(const BeamTreeView::Node& node, const PhotonLanes& p) {
  const auto foot = beamFoot(load(node.ax), load(node.ay), load(node.az), load(node.ux),
                             load(node.uy), load(node.uz), p.x, p.y, p.z);
  const Lanes r = load(node.r0) + load(node.k) * foot.t;
  return bitsOf(lessEqualMask(load(node.s0), foot.t) & lessEqualMask(foot.t, load(node.s1)) &
                lessEqualMask(foot.d2, r * r));
}

/// The feet of p on the beams of a block.
BRUME_KERNEL inline BeamFoot<Lanes> feetOn(const BeamTreeView::Block& block, const PhotonLanes& p) {
  return beamFoot(load(block.ox), load(block.oy), load(block.oz), load(block.dx), load(block.dy),
                  load(block.dz), p.x, p.y, p.z);
}

/// isInBeam eight times, as a mask.
BRUME_KERNEL inline Lanes insideMask(const BeamTreeView::Block& block,
                                     const BeamFoot<Lanes>& foot) {
  return lessEqualMask(load(block.t0), foot.t) & lessEqualMask(foot.t, load(block.t1)) &
         lessMask(foot.d2, load(block.radius2));
}

/// Searches go level by level for many photons at once, without a branch that depends on a test:
/// what may contain what is a list of pairs, and each level turns one list into the next. A pair is
/// photon << kNodeBits | node. Lists stand in the order of photons, then nodes.
inline constexpr std::uint32_t kNodeBits = 26;
inline constexpr std::uint32_t kNodeMask = (1u << kNodeBits) - 1;

/// Replaces nodes by their children that may contain the photon. Writes up to 8 pairs for each and 7
/// words more; returns how many pairs.
BRUME_KERNEL inline std::size_t expandPairs(const BeamTreeView::Node* nodes, const Vec3* photons,
                                            std::span<const std::uint32_t> pairs,
                                            std::uint32_t* to) {
  std::size_t count = 0;
  for (const std::uint32_t pair : pairs) {
    const std::uint32_t photon = pair >> kNodeBits, node = pair & kNodeMask;
    const LaneMask mask = childrenWith(nodes[node], PhotonLanes(photons[photon]));
    const auto children = static_cast<std::uint32_t>(kLanes) * node;
    compressIndices(photon << kNodeBits | children, mask, to + count);
    count += static_cast<std::size_t>(std::popcount(mask));
  }
  return count;
}

/// Pairs of photons of a group and the tiles that may contain them.
BRUME_KERNEL inline void findTiles(const BeamTreeView& tree, std::span<const Vec3> photons,
                                   PairLists& lists) {
  lists.now.clear();
  for (std::uint32_t i = 0; i < photons.size(); ++i) lists.now.push_back(i << kNodeBits);
  for (std::uint32_t level = tree.topLevel; level > tree.tileLevel; --level) {
    lists.next.resize(kLanes * (lists.now.size() + 1));
    lists.next.resize(expandPairs(tree.levels[level], photons.data(), lists.now, lists.next.data()));
    std::swap(lists.now, lists.next);
  }
}

/// Pairs of photons of a group and the cells of a tile, counted from its first, that may contain
/// them; they stand in `lists`.
BRUME_KERNEL inline std::span<const std::uint32_t> findCells(const BeamTreeView& tree,
                                                             std::size_t tile,
                                                             std::span<const Vec3> photons,
                                                             CellLists& lists) {
  std::uint32_t *now = lists.now.data(), *next = lists.next.data();
  std::size_t count = photons.size();
  for (std::uint32_t i = 0; i < count; ++i) now[i] = i << kNodeBits;
  for (std::uint32_t level = tree.tileLevel + 1; level-- > 0;) {
    const std::size_t first = tile << 3 * (tree.tileLevel - level);
    count = expandPairs(tree.levels[level] + first, photons.data(), {now, count}, next);
    std::swap(now, next);
  }
  return {now, count};
}

/// The blocks of the cell of a pair.
BRUME_KERNEL inline BlockRange blocksOfPair(const BeamTreeView& tree, std::size_t tile,
                                            std::uint32_t pair) {
  const std::uint32_t* begin =
      tree.blockBegin + tree.cellsPerTile() * tile + (pair & kNodeMask);
  return {begin[0], begin[1]};
}

/// Collects the pairs of photons of a group and slots.
BRUME_KERNEL inline void findPairsInTile(const BeamTreeView& tree, std::size_t tile,
                                         std::span<const Vec3> photons,
                                         std::span<const std::uint32_t> indices,
                                         CellLists& lists, BeamPairBuffer& found) {
  for (const std::uint32_t pair : findCells(tree, tile, photons, lists)) {
    const std::uint32_t photon = pair >> kNodeBits;
    const PhotonLanes p(photons[photon]);
    const BlockRange blocks = blocksOfPair(tree, tile, pair);
    for (std::uint32_t b = blocks.begin; b < blocks.end; ++b) {
      const BeamFoot<Lanes> foot = feetOn(tree.blocks[b], p);
      const LaneMask inside = bitsOf(insideMask(tree.blocks[b], foot));
      const BeamPairBuffer::Room room = found.room(kLanes);
      compressIndices(b * static_cast<std::uint32_t>(kLanes), inside, room.slots);
      compress(foot.t, inside, room.t);
      compress(foot.d2, inside, room.d2);
      std::fill_n(room.photons, kLanes, indices[photon]);
      found.keep(static_cast<std::size_t>(std::popcount(inside)));
    }
  }
}
