// SPDX-License-Identifier: Apache-2.0
// beam_gather.inl, and the same in media that vary along the beams.

#include "transport/beam_gather.inl"

/// Adds a photon with all of its lobes to the beams of a block that it is inside of.
BRUME_KERNEL inline void addToBlockInMedia(const BeamTreeView& tree, const TileGather& tile,
                                           TileMedia& media, std::span<const PhotonState> lobes,
                                           std::uint32_t b) {
  const BeamTreeView::Block& block = tree.blocks[b];
  const BeamFoot<Lanes> foot = feetOn(block, PhotonLanes(lobes[0].p));
  const Lanes mask = insideMask(block, foot);
  const LaneMask inside = bitsOf(mask);
  if (inside == 0) return;
  BlockSums& sums = tile.sums[b - tile.blocks.begin];
  countLanes(mask, sums.count.data());

  // Optical depths beam by beam; those outside stay 0 and have no weight.
  alignas(32) std::array<float, kLanes> way;
  alignas(32) std::array<std::array<float, kLanes>, 3> depths{};
  (foot.t - load(tree.startsOf(b))).store(way.data());
  bool isGrey = true;
  for (LaneMask rest = inside; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
    const DepthTables::Depth depth = media.depthAt(b * kLanes + lane, way[lane]);
    isGrey &= depth.isGrey;
    for (std::size_t c = 0; c < 3; ++c) depths[c][lane] = depth.of[c];
  }
  const Lanes K2 = kernelOf(block, foot.d2) & mask, zero = Lanes::all(0.f);
  std::array<Lanes, 3> Tr;
  Tr[0] = expOf(zero - Lanes::load(depths[0].data()));
  for (std::size_t c = 1; c < 3; ++c)
    Tr[c] = isGrey ? Tr[0] : expOf(zero - Lanes::load(depths[c].data()));

  for (const PhotonState& lobe : lobes) {
    const Lanes weight = lobe.a == 0 ? K2 : weightOf<false>(block, lobe, K2);
    for (std::size_t c = 0; c < 3; ++c) {
      const Lanes L = weight * Tr[c] * Lanes::all(lobe.power[c]);
      (Lanes::load(sums.L[c].data()) + L).store(sums.L[c].data());
    }
  }
}

/// Adds a group of photons, whose states stand in the scratch, to the sums of a tile.
BRUME_KERNEL inline void gatherGroupInMedia(const BeamTreeView& tree, const TileGather& tile,
                                            TileMedia& media, std::size_t count,
                                            LobeScratch& scratch) {
  std::array<Vec3, kPhotonGroup> positions;
  for (std::size_t i = 0; i < count; ++i) positions[i] = scratch.states[scratch.begin[i]].p;
  const auto pairs = findCells(tree, tile.tile, {positions.data(), count}, scratch.lists);
  for (const std::uint32_t pair : pairs) {
    const std::uint32_t photon = pair >> kNodeBits;
    const std::span<const PhotonState> lobes(scratch.states.data() + scratch.begin[photon],
                                             scratch.begin[photon + 1] - scratch.begin[photon]);
    const BlockRange blocks = blocksOfPair(tree, tile.tile, pair);
    for (std::uint32_t b = blocks.begin; b < blocks.end; ++b)
      addToBlockInMedia(tree, tile, media, lobes, b);
  }
}
