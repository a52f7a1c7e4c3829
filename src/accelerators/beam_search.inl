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

/// Calls visitor.visit(block, index of the block, p) for the blocks of a tile that may contain p.
template <class Visitor>
BRUME_KERNEL inline void visitTile(const BeamTreeView& tree, std::size_t tile, const PhotonLanes& p,
                                   Visitor& visitor) {
  const auto visitCells = [&](std::size_t node) BRUME_KERNEL {
    LaneMask mask = childrenWith(tree.levels[0][node], p);
    for (; mask != 0; mask &= mask - 1) {
      const std::size_t cell = node * kLanes + static_cast<std::size_t>(std::countr_zero(mask));
      for (std::uint32_t b = tree.blockBegin[cell]; b < tree.blockBegin[cell + 1]; ++b)
        visitor.visit(tree.blocks[b], b, p);
    }
  };
  if (tree.tileLevel == 0) return visitCells(tile);
  LaneMask mask = childrenWith(tree.levels[1][tile], p);
  for (; mask != 0; mask &= mask - 1)
    visitCells(tile * kLanes + static_cast<std::size_t>(std::countr_zero(mask)));
}

/// Writes the tiles that may contain p to `tiles`, which has room for all.
BRUME_KERNEL inline std::size_t findTiles(const BeamTreeView& tree, const Vec3& position,
                                          std::uint32_t* tiles) {
  const PhotonLanes p(position);
  struct Entry {
    std::uint32_t level, node;
  };
  std::array<Entry, kLanes * BeamTreeView::kMaxLevels> stack;
  std::size_t size = 0, count = 0;
  stack[size++] = {tree.topLevel, 0};
  while (size > 0) {
    const auto [level, node] = stack[--size];
    if (level == tree.tileLevel) {
      tiles[count++] = node;
      continue;
    }
    // The last child goes to the stack first: tiles are found in their order.
    LaneMask mask = childrenWith(tree.levels[level][node], p);
    while (mask != 0) {
      const int last = std::bit_width(mask) - 1;
      stack[size++] = {level - 1,
                       node * static_cast<std::uint32_t>(kLanes) + static_cast<std::uint32_t>(last)};
      mask &= ~(LaneMask{1} << last);
    }
  }
  return count;
}

/// Collects pairs.
struct PairVisitor {
  BeamPairBuffer& found;
  std::uint32_t photon;

  BRUME_KERNEL void visit(const BeamTreeView::Block& block, std::uint32_t b, const PhotonLanes& p) {
    const BeamFoot<Lanes> foot = feetOn(block, p);
    const LaneMask inside = bitsOf(insideMask(block, foot));
    if (inside == 0) return;
    const BeamPairBuffer::Room room = found.room(kLanes);
    compressIndices(b * static_cast<std::uint32_t>(kLanes), inside, room.slots);
    compress(foot.t, inside, room.t);
    compress(foot.d2, inside, room.d2);
    const auto n = static_cast<std::size_t>(std::popcount(inside));
    std::fill_n(room.photons, n, photon);
    found.keep(n);
  }
};

BRUME_KERNEL inline void findPairsInTile(const BeamTreeView& tree, std::size_t tile,
                                         const PhotonPositions& photons,
                                         std::span<const std::uint32_t> indices,
                                         BeamPairBuffer& found) {
  for (const std::uint32_t i : indices) {
    PairVisitor visitor{found, i};
    visitTile(tree, tile, PhotonLanes(photons[i]), visitor);
  }
}
