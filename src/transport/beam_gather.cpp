// SPDX-License-Identifier: Apache-2.0
#include "transport/beam_gather.h"

#include <algorithm>
#include <bit>

#include "accelerators/lanes_math.h"

namespace brume {
namespace {

using BlockRange = BeamQuadtree::BlockRange;

/// Photons of a tile that are added in float before the sums go on in double: few enough that the
/// rounding of a sum stays about 1e-6 of it.
constexpr std::size_t kPhotonsInFloat = 4096;

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

/// What all photons of a tile share.
struct TileGather {
  std::array<float, 3> sigma_t;
  bool isGray;   ///< sigma_t is the same in all channels
  float tStart;  ///< transmittance is counted from here on all beams of the tile...
  bool isWide;   ///< ...unless they start too far apart: then each from its own start
  BlockRange blocks;
  BlockSums* sums;
};

/// Number of optical depths between the starts of a tile's beams from which it is wide: below, no
/// transmittance that matters underflows.
constexpr float kWideDepth = 10;

/// Takes in the tile's blocks [begin, end) and its medium.
TileGather makeTileGather(const BeamTreeView& tree, BlockRange blocks, const Rgb& sigma_t,
                          BlockSums* sums) {
  float first = kInfinity, last = -kInfinity;
  for (std::uint32_t b = blocks.begin; b < blocks.end; ++b)
    for (const float t : tree.startsOf(b)) {
      if (t == kInfinity) continue;  // no beam
      first = std::min(first, t);
      last = std::max(last, t);
    }
  const bool isGray = sigma_t.r == sigma_t.g && sigma_t.g == sigma_t.b;
  const bool isWide = (last - first) * sigma_t.maxChannel() > kWideDepth;
  return {{sigma_t.r, sigma_t.g, sigma_t.b}, isGray, first, isWide, blocks, sums};
}

namespace generic {
using namespace lanes_generic;
#define BRUME_KERNEL
#include "accelerators/beam_search.inl"
#include "transport/beam_gather.inl"
#undef BRUME_KERNEL
}  // namespace generic

#if BRUME_HAS_AVX2
namespace avx2 {
using namespace lanes_avx2;
#define BRUME_KERNEL BRUME_AVX2
#include "accelerators/beam_search.inl"
#include "transport/beam_gather.inl"
#undef BRUME_KERNEL
}  // namespace avx2
#else
namespace avx2 = generic;
#endif

void addTo(std::span<BeamSum> sums, const BlockSums& block, std::uint32_t b,
           std::span<const std::uint32_t> sumOfSlot) {
  for (std::size_t i = 0; i < kLanes; ++i) {
    if (block.count[i] == 0) continue;
    const std::size_t slot = b * kLanes + i;
    sums[sumOfSlot.empty() ? slot : sumOfSlot[slot]] += BeamSum{
        double{block.L[0][i]}, double{block.L[1][i]}, double{block.L[2][i]}, block.count[i]};
  }
}

/// Adds photons to the sums of slots, or of what sumOfSlot names for each.
void gatherTile(const BeamQuadtree& tree, std::size_t tile, std::span<const BeamPhoton> photons,
                std::span<const std::uint32_t> indices, const Rgb& sigma_t, std::span<BeamSum> sums,
                std::span<const std::uint32_t> sumOfSlot) {
  const BlockRange blocks = tree.blocksOf(tile);
  std::vector<BlockSums> ofBlocks(blocks.end - blocks.begin);
  const TileGather gather = makeTileGather(tree.view(), blocks, sigma_t, ofBlocks.data());
  while (!indices.empty()) {
    const auto some = indices.first(std::min(indices.size(), kPhotonsInFloat));
    indices = indices.subspan(some.size());
    if (hasAvx2())
      avx2::gatherInTile(tree.view(), tile, photons, some, gather);
    else
      generic::gatherInTile(tree.view(), tile, photons, some, gather);
    for (std::uint32_t b = blocks.begin; b < blocks.end; ++b) {
      BlockSums& block = ofBlocks[b - blocks.begin];
      if (!block.isTouched()) continue;
      addTo(sums, block, b, sumOfSlot);
      block = {};
    }
  }
}

}  // namespace

void gatherHomogeneous(const BeamQuadtree& tree, std::span<const BeamPhoton> photons,
                       const Rgb& sigma_t, std::span<BeamSum> sums) {
  const auto slotBeams = tree.slotBeams();
  std::vector<BeamSum> slotSums(tree.hasPieces() ? slotBeams.size() : 0);
  tree.forEachTile(PhotonPositions(photons, &BeamPhoton::p),
                   [&](std::size_t tile, std::span<const std::uint32_t> indices) {
                     if (tree.hasPieces())
                       gatherTile(tree, tile, photons, indices, sigma_t, slotSums, {});
                     else
                       gatherTile(tree, tile, photons, indices, sigma_t, sums, slotBeams);
                   });
  for (std::size_t slot = 0; slot < slotSums.size(); ++slot)
    if (slotSums[slot].count > 0) sums[slotBeams[slot]] += slotSums[slot];
}

}  // namespace brume
