// SPDX-License-Identifier: Apache-2.0
#include "transport/beam_gather.h"

#include <algorithm>
#include <bit>

#include "core/lanes_math.h"
#include "transport/depth_tables.h"

namespace brume {
namespace {

/// Photons of a tile that are added in float before the sums go on in double: few enough that the
/// rounding of a sum stays about 1e-6 of it.
constexpr std::size_t kPhotonsInFloat = 4096;

/// Blocks by which fetchAhead() runs before their sums are added.
constexpr std::uint32_t kBlocksAhead = 4;

/// The sums of one block's beams, before what is the same for all photons of a beam.
struct alignas(32) BlockSums {
  std::array<std::array<float, kLanes>, 3> L{};
  std::array<std::uint32_t, kLanes> count{};

  bool isTouched() const {
    std::uint32_t any = 0;
    for (const std::uint32_t n : count) any |= n;
    return any != 0;
  }
};

/// A photon on its way through a tile.
struct alignas(64) PhotonState {
  Vec3 p, w;                   ///< w is turned for g < 0
  float a, oneMinusA2;         ///< a = |g|: denominator of p: (1 - a)^2 + a |d + w|^2
  std::array<float, 3> power;  ///< with the constant factor of p
  float tKnown;                ///< where the transmittance is known
  bool isNarrow = false;       ///< c0 + c1 x is enough for all beams that it is inside of
  Vec3 q{0};                   ///< then: from the origin of the tile's beams
  /// Of each channel: power times transmittance at t = tKnown - x is c0 + c1 x + c2 x^2 + c3 x^3.
  std::array<std::array<float, 4>, 3> series;
};

/// What all photons of a tile share.
struct TileGather {
  std::size_t tile;
  BlockRange blocks;
  std::array<float, 3> sigma_t;
  float reach;                 ///< way by which a transmittance is continued; below 0: none is
  float tStart;                ///< transmittance is counted from here on all beams of the tile...
  bool isWide;                 ///< ...unless they start too far apart: then each from its own start
  bool isEven;                 ///< all beams start at tStart
  bool isGray;                 ///< sigma_t is the same in all channels
  std::optional<Vec3> origin;  ///< of all beams, where a photon may be narrow
  float narrowReach = 0;       ///< from there on photons are
  BlockSums* sums;
};

/// Optical depth x up to which 1 + x + x^2/2 + x^3/6 stands for e^x: relative error below 4e-8.
constexpr float kSeriesReach = 0.03f;

/// And up to which 1 + x does.
constexpr float kLinearReach = 2.8e-4f;

/// Number of optical depths between the starts of a tile's beams from which it is wide: below, no
/// transmittance that matters underflows.
constexpr float kWideDepth = 10;

PhotonState stateOf(const BeamPhoton& photon) {
  const float sign = photon.g < 0 ? -1.f : 1.f, a = sign * photon.g;
  const float phase = kInv4Pi * (1.f - a) * (1.f + a);
  return {photon.p,
          sign * photon.w,
          a,
          sqr(1.f - a),
          {photon.power.r * phase, photon.power.g * phase, photon.power.b * phase},
          0,
          false,
          Vec3(0),
          {}};
}

/// The media along a tile's beams.
class TileMedia {
 public:
  TileMedia(const BeamQuadtree& tree, BlockRange blocks, const MediumOfBeam& mediumOf,
            DepthTables& tables)
      : tree_(tree), firstSlot_(blocks.begin * kLanes), mediumOf_(mediumOf), tables_(tables) {
    tables_.reset((blocks.end - blocks.begin) * kLanes);
  }
  DepthTables::Depth depthAt(std::size_t slot, float s) {
    if (!tables_.isFilled(slot - firstSlot_)) fill(slot);
    return tables_.at(slot - firstSlot_, s);
  }

 private:
  [[gnu::noinline]] void fill(std::size_t slot) {
    thread_local MediumAlongRay medium;  // reused, so that its memory is
    mediumOf_(tree_.slotBeams()[slot], medium);
    tables_.fill(slot - firstSlot_, medium,
                 tree_.view().startsOf(static_cast<std::uint32_t>(slot / kLanes))[slot % kLanes]);
  }

  const BeamQuadtree& tree_;
  std::size_t firstSlot_;
  const MediumOfBeam& mediumOf_;
  DepthTables& tables_;
};

/// Room for a group of photons with all of their lobes.
struct LobeScratch {
  CellLists lists;
  std::vector<PhotonState> states;
  std::array<std::uint32_t, kPhotonGroup + 1> begin;  ///< of each photon's states
};

/// Room for a group of photons.
struct GroupScratch {
  CellLists lists;
  std::array<PhotonState, kPhotonGroup> states;
};

#define BRUME_KERNELS "transport/beam_gather_media.inl"
#include "core/both_lanes.inl"

TileGather makeTileGather(const BeamQuadtree& tree, std::size_t tile, const Rgb& sigma_t,
                          std::vector<BlockSums>& sums) {
  const BlockRange blocks = tree.blocksOf(tile);
  sums.resize(blocks.end - blocks.begin);
  const BeamQuadtree::TileBounds& bounds = tree.boundsOf(tile);
  const auto [first, last] = bounds.starts;
  TileGather gather{};
  gather.tile = tile;
  gather.blocks = blocks;
  gather.sigma_t = {sigma_t.r, sigma_t.g, sigma_t.b};
  gather.tStart = first;
  gather.isWide = (last - first) * sigma_t.maxChannel() > kWideDepth;
  gather.reach = gather.isWide ? -1.f : kSeriesReach / sigma_t.maxChannel();
  gather.isEven = first == last;
  gather.isGray = sigma_t.r == sigma_t.g && sigma_t.g == sigma_t.b;
  if (!gather.isWide) gather.origin = bounds.origin;
  gather.narrowReach = bounds.radius2 * sigma_t.maxChannel() / kLinearReach;
  gather.sums = sums.data();
  return gather;
}

/// Adds photons to the sums of a tile, in groups.
void gatherSome(const BeamQuadtree& tree, const TileGather& gather,
                std::span<const BeamPhoton> photons, std::span<const std::uint32_t> indices) {
  GroupScratch scratch;
  while (!indices.empty()) {
    const auto group = indices.first(std::min(kPhotonGroup, indices.size()));
    if (hasAvx2())
      avx2::gatherGroup(tree.view(), gather, photons, group, scratch);
    else
      generic::gatherGroup(tree.view(), gather, photons, group, scratch);
    indices = indices.subspan(group.size());
  }
}

/// Asks the memory for the sums that a block goes to: they stand in the order of the image, blocks
/// in Morton order, which no processor guesses.
void fetchAhead(std::uint32_t b, std::span<BeamSum> sums,
                std::span<const std::uint32_t> sumOfSlot) {
  if (sumOfSlot.empty()) return;
  for (std::size_t i = 0; i < kLanes; i += 2) {
    const std::uint32_t index = sumOfSlot[b * kLanes + i];
    if (index != BeamLookup::kNoBeam) __builtin_prefetch(&sums[index], 1);
  }
}

/// Adds the sums of a block, which are left at zero, to those of slots, or of what sumOfSlot names
/// for each.
void flush(const BeamQuadtree& tree, const TileGather& gather, std::uint32_t b,
           std::span<BeamSum> sums, std::span<const std::uint32_t> sumOfSlot) {
  BlockSums& block = gather.sums[b - gather.blocks.begin];
  if (!block.isTouched()) return;
  if (hasAvx2())
    avx2::finishBlock(tree.view(), gather, b, block);
  else
    generic::finishBlock(tree.view(), gather, b, block);
  for (std::size_t i = 0; i < kLanes; ++i) {
    if (block.count[i] == 0) continue;
    const std::size_t slot = b * kLanes + i;
    sums[sumOfSlot.empty() ? slot : sumOfSlot[slot]] += BeamSum{
        double{block.L[0][i]}, double{block.L[1][i]}, double{block.L[2][i]}, block.count[i]};
  }
  block = {};
}

void flushAll(const BeamQuadtree& tree, const TileGather& gather, std::span<BeamSum> sums,
              std::span<const std::uint32_t> sumOfSlot) {
  for (std::uint32_t b = gather.blocks.begin; b < gather.blocks.end; ++b) {
    if (b + kBlocksAhead < gather.blocks.end) fetchAhead(b + kBlocksAhead, sums, sumOfSlot);
    flush(tree, gather, b, sums, sumOfSlot);
  }
}

void gatherTile(const BeamQuadtree& tree, std::size_t tile, std::span<const BeamPhoton> photons,
                std::span<const std::uint32_t> indices, const Rgb& sigma_t, std::span<BeamSum> sums,
                std::span<const std::uint32_t> sumOfSlot) {
  std::vector<BlockSums> ofBlocks;
  const TileGather gather = makeTileGather(tree, tile, sigma_t, ofBlocks);
  while (!indices.empty()) {
    const auto some = indices.first(std::min(indices.size(), kPhotonsInFloat));
    indices = indices.subspan(some.size());
    gatherSome(tree, gather, photons, some);
    flushAll(tree, gather, sums, sumOfSlot);
  }
}

/// The states of a group's photons, lobe by lobe.
void findStates(std::span<const BeamPhoton> photons, std::span<const BeamLobe> lobes,
                std::span<const std::uint32_t> indices, LobeScratch& scratch) {
  scratch.states.clear();
  for (std::size_t i = 0; i < indices.size(); ++i) {
    scratch.begin[i] = static_cast<std::uint32_t>(scratch.states.size());
    BeamPhoton photon = photons[indices[i]];
    scratch.states.push_back(stateOf(photon));
    for (const BeamLobe& lobe : lobes.subspan(photon.lobesBegin, photon.lobeCount)) {
      photon.power = lobe.power;
      photon.g = lobe.g;
      scratch.states.push_back(stateOf(photon));
    }
  }
  scratch.begin[indices.size()] = static_cast<std::uint32_t>(scratch.states.size());
}

void gatherTileInMedia(const BeamQuadtree& tree, std::size_t tile,
                       std::span<const BeamPhoton> photons, std::span<const BeamLobe> lobes,
                       std::span<const std::uint32_t> indices, const MediumOfBeam& mediumOf,
                       std::span<BeamSum> sums, std::span<const std::uint32_t> sumOfSlot) {
  thread_local DepthTables tables;  // reused, so that its memory is
  std::vector<BlockSums> ofBlocks;
  TileGather gather{};
  gather.tile = tile;
  gather.blocks = tree.blocksOf(tile);
  gather.isWide = true;  // transmittance is counted from each beam's start
  ofBlocks.resize(gather.blocks.end - gather.blocks.begin);
  gather.sums = ofBlocks.data();
  TileMedia media(tree, gather.blocks, mediumOf, tables);
  LobeScratch scratch;
  while (!indices.empty()) {
    auto some = indices.first(std::min(indices.size(), kPhotonsInFloat));
    indices = indices.subspan(some.size());
    for (; !some.empty(); some = some.subspan(std::min(kPhotonGroup, some.size()))) {
      const auto group = some.first(std::min(kPhotonGroup, some.size()));
      findStates(photons, lobes, group, scratch);
      if (hasAvx2())
        avx2::gatherGroupInMedia(tree.view(), gather, media, group.size(), scratch);
      else
        generic::gatherGroupInMedia(tree.view(), gather, media, group.size(), scratch);
    }
    flushAll(tree, gather, sums, sumOfSlot);
  }
}

/// Calls body(tile, indices, sums, sumOfSlot) and adds what the pieces of beams got to the beams.
template <class Body>
void forEachTileWithSums(const BeamQuadtree& tree, std::span<const BeamPhoton> photons,
                         std::span<BeamSum> sums, const Body& body) {
  const auto slotBeams = tree.slotBeams();
  std::vector<BeamSum> slotSums(tree.hasPieces() ? slotBeams.size() : 0);
  tree.forEachTile(PhotonPositions(photons, &BeamPhoton::p),
                   [&](std::size_t tile, std::span<const std::uint32_t> indices) {
                     if (tree.hasPieces())
                       body(tile, indices, std::span(slotSums), std::span<const std::uint32_t>());
                     else
                       body(tile, indices, sums, slotBeams);
                   });
  for (std::size_t slot = 0; slot < slotSums.size(); ++slot)
    if (slotSums[slot].count > 0) sums[slotBeams[slot]] += slotSums[slot];
}

}  // namespace

void gatherHomogeneous(const BeamQuadtree& tree, std::span<const BeamPhoton> photons,
                       const Rgb& sigma_t, std::span<BeamSum> sums) {
  forEachTileWithSums(tree, photons, sums,
                      [&](std::size_t tile, std::span<const std::uint32_t> indices,
                          std::span<BeamSum> to, std::span<const std::uint32_t> sumOfSlot) {
                        gatherTile(tree, tile, photons, indices, sigma_t, to, sumOfSlot);
                      });
}

void gatherInMedia(const BeamQuadtree& tree, std::span<const BeamPhoton> photons,
                   std::span<const BeamLobe> lobes, const MediumOfBeam& mediumOf,
                   std::span<BeamSum> sums) {
  forEachTileWithSums(tree, photons, sums,
                      [&](std::size_t tile, std::span<const std::uint32_t> indices,
                          std::span<BeamSum> to, std::span<const std::uint32_t> sumOfSlot) {
                        gatherTileInMedia(tree, tile, photons, lobes, indices, mediumOf, to,
                                          sumOfSlot);
                      });
}

}  // namespace brume
