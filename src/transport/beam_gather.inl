// SPDX-License-Identifier: Apache-2.0
// Evaluation of photons in the beams of a tile, included once for each kind of Lanes (lanes.h).

#include "accelerators/beam_search.inl"
#include "accelerators/lanes_exp.inl"

/// K2 without its factor.
BRUME_KERNEL inline Lanes kernelOf(const BeamTreeView::Block& block, const Lanes& d2) {
  const Lanes q = Lanes::all(1.f) - d2 * load(block.inverseRadius2);
  return q * q;
}

/// K2 times the phase function, without their constant factors.
template <bool kIsotropic>
BRUME_KERNEL inline Lanes weightOf(const BeamTreeView::Block& block, const PhotonState& photon,
                                   const Lanes& K2) {
  if constexpr (kIsotropic) return K2;
  const Lanes ex = load(block.dx) + Lanes::all(photon.w.x);
  const Lanes ey = load(block.dy) + Lanes::all(photon.w.y);
  const Lanes ez = load(block.dz) + Lanes::all(photon.w.z);
  const Lanes denominator =
      Lanes::all(photon.oneMinusA2) + Lanes::all(photon.a) * (ex * ex + ey * ey + ez * ez);
  return K2 / (denominator * sqrt(denominator));
}

BRUME_KERNEL inline Lanes seriesAt(const std::array<float, 4>& c, const Lanes& x) {
  return Lanes::all(c[0]) + x * (Lanes::all(c[1]) + x * (Lanes::all(c[2]) + x * Lanes::all(c[3])));
}

/// Its first two terms.
BRUME_KERNEL inline Lanes lineAt(const std::array<float, 4>& c, const Lanes& x) {
  return Lanes::all(c[0]) + x * Lanes::all(c[1]);
}

/// With the transmittance known at a neighbour's t and continued by x = tKnown - t.
template <bool kGray>
BRUME_KERNEL inline void addNear(const PhotonState& photon, const Lanes& weight, const Lanes& x,
                                 BlockSums& sums) {
  const Lanes gray = kGray ? weight * seriesAt(photon.series[0], x) : weight;
  for (std::size_t c = 0; c < 3; ++c) {
    const Lanes L = gray * (kGray ? Lanes::all(photon.power[c]) : seriesAt(photon.series[c], x));
    (Lanes::load(sums.L[c].data()) + L).store(sums.L[c].data());
  }
}

/// With an exponential for each beam.
BRUME_KERNEL inline void addFar(const TileGather& tile, const PhotonState& photon,
                                const Lanes& weight, const Lanes& way, BlockSums& sums) {
  for (std::size_t c = 0; c < 3; ++c) {
    const Lanes Tr = expOf(way * Lanes::all(-tile.sigma_t[c]));
    const Lanes L = weight * Tr * Lanes::all(photon.power[c]);
    (Lanes::load(sums.L[c].data()) + L).store(sums.L[c].data());
  }
}

/// Adds a photon to the beams of a block that it is inside of.
template <bool kIsotropic, bool kGray>
BRUME_KERNEL inline void addToBlock(const BeamTreeView& tree, const TileGather& tile,
                                    const PhotonState& photon, std::uint32_t b) {
  const BeamTreeView::Block& block = tree.blocks[b];
  const BeamFoot<Lanes> foot = feetOn(block, PhotonLanes(photon.p));
  const Lanes mask = insideMask(block, foot);
  BlockSums& sums = tile.sums[b - tile.blocks.begin];
  countLanes(mask, sums.count.data());
  const Lanes weight = weightOf<kIsotropic>(block, photon, kernelOf(block, foot.d2)) & mask;
  // Neighbouring beams have the photon at nearly the same t.
  const Lanes x = (Lanes::all(photon.tKnown) - foot.t) & mask, reach = Lanes::all(tile.reach);
  const LaneMask isNear =
      bitsOf(lessEqualMask(x, reach) & lessEqualMask(Lanes::all(0.f) - reach, x));
  if (isNear == 0xff)
    addNear<kGray>(photon, weight, x, sums);
  else if (tile.isWide)
    addFar(tile, photon, weight, (foot.t - load(tree.startsOf(b))) & mask, sums);
  else
    addFar(tile, photon, weight, (foot.t - Lanes::all(tile.tStart)) & mask, sums);
}

/// The same for a narrow photon: its beams have it at nearly the same t, tKnown - x. From a common
/// origin at the distance l = tKnown, 0 <= x = l - t = d^2 / (l + t) < radius^2 / l.
template <bool kIsotropic, bool kGray>
BRUME_KERNEL inline void addNarrow(const BeamTreeView::Block& block, const PhotonState& photon,
                                   BlockSums& sums) {
  const BeamFoot<Lanes> foot =
      beamFoot(Lanes::all(photon.q.x), Lanes::all(photon.q.y), Lanes::all(photon.q.z),
               load(block.dx), load(block.dy), load(block.dz));
  const Lanes mask = insideMask(block, foot);
  countLanes(mask, sums.count.data());
  const Lanes weight = weightOf<kIsotropic>(block, photon, kernelOf(block, foot.d2)) & mask;
  const Lanes x = Lanes::all(photon.tKnown) - foot.t;
  const Lanes gray = kGray ? weight * lineAt(photon.series[0], x) : weight;
  for (std::size_t c = 0; c < 3; ++c) {
    const Lanes L = gray * (kGray ? Lanes::all(photon.power[c]) : lineAt(photon.series[c], x));
    (Lanes::load(sums.L[c].data()) + L).store(sums.L[c].data());
  }
}

/// t on one of the beams that may contain the photon; not before tStart, where the transmittance
/// would grow.
inline float nearT(const BeamTreeView::Block& block, const TileGather& tile, const Vec3& p) {
  const auto foot = beamFoot<float>(block.ox[0], block.oy[0], block.oz[0], block.dx[0], block.dy[0],
                                    block.dz[0], p.x, p.y, p.z);
  return std::max(foot.t, tile.tStart);
}

/// Power times transmittance around tKnown; two terms, where that is enough for all of them.
BRUME_KERNEL inline void findSeries(const TileGather& tile, bool areNarrow,
                                    std::span<PhotonState> photons) {
  for (std::size_t first = 0; first < photons.size(); first += kLanes) {
    const auto some = photons.subspan(first, std::min(kLanes, photons.size() - first));
    std::array<float, kLanes> way{};
    for (std::size_t i = 0; i < some.size(); ++i) way[i] = some[i].tKnown - tile.tStart;
    for (std::size_t c = 0; c < 3; ++c) {
      const float sigma = tile.sigma_t[c];
      std::array<float, kLanes> Tr;
      expOf(Lanes::load(way.data()) * Lanes::all(-sigma)).store(Tr.data());
      for (std::size_t i = 0; i < some.size(); ++i) {
        std::array<float, 4>& series = some[i].series[c];
        series[0] = tile.isGray ? Tr[i] : Tr[i] * some[i].power[c];
        series[1] = series[0] * sigma;
      }
      if (!areNarrow)
        for (PhotonState& photon : some) {
          std::array<float, 4>& series = photon.series[c];
          series[2] = series[1] * sigma * 0.5f;
          series[3] = series[2] * sigma * (1.f / 3);
        }
      if (tile.isGray) break;
    }
  }
}

template <bool kIsotropic, bool kGray>
BRUME_KERNEL inline void gatherPairs(const BeamTreeView& tree, const TileGather& tile,
                                     std::span<const PhotonState> photons,
                                     std::span<const std::uint32_t> pairs) {
  for (const std::uint32_t pair : pairs) {
    const PhotonState& photon = photons[pair >> kNodeBits];
    const BlockRange blocks = blocksOfPair(tree, tile.tile, pair);
    if (photon.isNarrow)
      for (std::uint32_t b = blocks.begin; b < blocks.end; ++b)
        addNarrow<kIsotropic, kGray>(tree.blocks[b], photon, tile.sums[b - tile.blocks.begin]);
    else
      for (std::uint32_t b = blocks.begin; b < blocks.end; ++b)
        addToBlock<kIsotropic, kGray>(tree, tile, photon, b);
  }
}

/// Where the transmittance of photons that are not narrow is known: in the first cell of each.
BRUME_KERNEL inline void findKnown(const BeamTreeView& tree, const TileGather& tile,
                                   std::span<const std::uint32_t> pairs,
                                   std::span<PhotonState> photons) {
  // Without branches that depend on the pairs; the first cell of a photon is written last.
  std::array<std::uint32_t, kPhotonGroup> nearBlock;
  nearBlock.fill(tile.blocks.begin);
  for (std::size_t i = pairs.size(); i-- > 0;)
    nearBlock[pairs[i] >> kNodeBits] = blocksOfPair(tree, tile.tile, pairs[i]).begin;
  for (std::size_t i = 0; i < photons.size(); ++i)
    if (!photons[i].isNarrow)
      photons[i].tKnown = nearT(tree.blocks[nearBlock[i]], tile, photons[i].p);
}

/// Makes the photons of a group ready for the cells that they may be in.
BRUME_KERNEL inline void prepareGroup(const BeamTreeView& tree, const TileGather& tile,
                                      std::span<const BeamPhoton> photons,
                                      std::span<const std::uint32_t> indices,
                                      std::span<const std::uint32_t> pairs, PhotonState* states) {
  bool areNarrow = true;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    PhotonState& state = states[i];
    state = stateOf(photons[indices[i]]);
    if (tile.origin) {
      const float l = distance(state.p, *tile.origin);
      // Nearer than tStart it is in no beam, and the transmittance would grow.
      state.isNarrow = l >= std::max(tile.narrowReach, tile.tStart);
      state.q = state.p - *tile.origin;
      state.tKnown = l;
    }
    areNarrow &= state.isNarrow;
  }
  if (!areNarrow) findKnown(tree, tile, pairs, {states, indices.size()});
  findSeries(tile, areNarrow, {states, indices.size()});
}

/// Adds a group of photons to the sums of a tile.
BRUME_KERNEL inline void gatherGroup(const BeamTreeView& tree, const TileGather& tile,
                                     std::span<const BeamPhoton> photons,
                                     std::span<const std::uint32_t> indices,
                                     GroupScratch& scratch) {
  std::array<Vec3, kPhotonGroup> positions;
  for (std::size_t i = 0; i < indices.size(); ++i) positions[i] = photons[indices[i]].p;
  const auto pairs = findCells(tree, tile.tile, {positions.data(), indices.size()}, scratch.lists);
  prepareGroup(tree, tile, photons, indices, pairs, scratch.states.data());
  const std::span<const PhotonState> states(scratch.states.data(), indices.size());
  bool isIsotropic = true;
  for (const PhotonState& photon : states) isIsotropic &= photon.a == 0;
  if (isIsotropic && tile.isGray)
    gatherPairs<true, true>(tree, tile, states, pairs);
  else if (isIsotropic)
    gatherPairs<true, false>(tree, tile, states, pairs);
  else if (tile.isGray)
    gatherPairs<false, true>(tree, tile, states, pairs);
  else
    gatherPairs<false, false>(tree, tile, states, pairs);
}

/// The sums of a block in their unit: with the kernel's factor, and transmittance counted from each
/// beam's start.
BRUME_KERNEL inline void finishBlock(const BeamTreeView& tree, const TileGather& tile,
                                     std::uint32_t b, BlockSums& sums) {
  const Lanes peak = load(tree.blocks[b].inverseRadius2) * Lanes::all(3.f * kInvPi);
  const bool isCounted = !tile.isWide && !tile.isEven;
  for (std::size_t c = 0; c < 3; ++c) {
    Lanes L = Lanes::load(sums.L[c].data()) * peak;
    if (isCounted) {
      const Lanes before = load(tree.startsOf(b)) - Lanes::all(tile.tStart);
      L = L * expOf(before * Lanes::all(tile.sigma_t[c]));
    }
    L.store(sums.L[c].data());
  }
}
