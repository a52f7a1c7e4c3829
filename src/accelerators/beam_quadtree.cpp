// SPDX-License-Identifier: Apache-2.0
#include "accelerators/beam_quadtree.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "accelerators/beam_order.h"
#include "core/counting_sort.h"
#include "core/error.h"
#include "core/lanes_math.h"
#include "core/parallel.h"

namespace brume {
namespace {

/// Tiles are the nodes of the highest level, up to this one, that has so many of them.
constexpr std::uint32_t kMostTileLevel = 2;
constexpr std::size_t kFewestTiles = 64;
/// Cells or nodes that one task of the build bounds.
constexpr std::int64_t kCellsAtOnce = 512;
/// Photons that one task distributes to tiles.
constexpr std::int64_t kPhotonsAtOnce = 512;
/// Places in tiles that a batch of photons aims at, a bound on memory; photons it is judged by.
constexpr std::size_t kBatchPlaces = std::size_t{1} << 21;
constexpr std::size_t kPilotPhotons = 256;

std::size_t divideUp(std::size_t a, std::size_t b) { return (a + b - 1) / b; }

void setChild(BeamTreeView::Node& node, std::size_t i, const BeamFrustum& f) {
  node.ax[i] = f.a.x;
  node.ay[i] = f.a.y;
  node.az[i] = f.a.z;
  node.ux[i] = f.u.x;
  node.uy[i] = f.u.y;
  node.uz[i] = f.u.z;
  node.s0[i] = f.s0;
  node.s1[i] = f.s1;
  node.r0[i] = f.r0;
  node.k[i] = f.k;
}

void setBeam(BeamTreeView::Block& block, std::size_t i, const Beam& beam) {
  block.ox[i] = beam.o.x;
  block.oy[i] = beam.o.y;
  block.oz[i] = beam.o.z;
  block.dx[i] = beam.d.x;
  block.dy[i] = beam.d.y;
  block.dz[i] = beam.d.z;
  block.t0[i] = beam.t0;
  block.t1[i] = beam.t1;
  block.radius2[i] = sqr(beam.radius);
  block.inverseRadius2[i] = 1.f / block.radius2[i];
}

#define BRUME_KERNELS "accelerators/beam_search.inl"
#include "core/both_lanes.inl"

/// A photon's place in a tile.
struct Place {
  std::uint32_t tile, photon;
};

/// The places of a batch, by tile, photons in their order.
struct PlacesByTile {
  std::vector<std::uint32_t> begin, photons;
};

PlacesByTile sortPlaces(const std::vector<std::vector<Place>>& chunks, std::size_t tileCount) {
  std::size_t count = 0;
  for (const auto& chunk : chunks) count += chunk.size();
  PlacesByTile sorted;
  sorted.photons.resize(count);
  const std::size_t groups = sortGroups(count, tileCount, chunks.size());
  sorted.begin = countingSort(
      groups, tileCount,
      [&](std::size_t group, const auto& f) {
        const auto [first, end] = groupRange(group, groups, chunks.size());
        for (std::size_t i = first; i < end; ++i)
          for (const Place& place : chunks[i]) f(place);
      },
      [](const Place& place) { return place.tile; },
      [&](const Place& place, std::uint32_t at) { sorted.photons[at] = place.photon; });
  return sorted;
}

/// Appends the places of the photons [begin, end).
void findPlaces(const BeamTreeView& tree, const PhotonPositions& photons, std::size_t begin,
                std::size_t end, PairLists& lists, std::vector<Place>& places) {
  std::array<Vec3, kPhotonGroup> group;
  for (; begin < end; begin += kPhotonGroup) {
    const std::size_t n = std::min(kPhotonGroup, end - begin);
    for (std::size_t i = 0; i < n; ++i) group[i] = photons[begin + i];
    if (hasAvx2())
      avx2::findTiles(tree, {group.data(), n}, lists);
    else
      generic::findTiles(tree, {group.data(), n}, lists);
    for (const std::uint32_t pair : lists.now)
      places.push_back({pair & generic::kNodeMask,
                        static_cast<std::uint32_t>(begin + (pair >> generic::kNodeBits))});
  }
}

/// The places of the photons [first, first + count).
PlacesByTile placesOf(const BeamTreeView& tree, std::size_t tileCount,
                      const PhotonPositions& photons, std::size_t first, std::size_t count) {
  std::vector<std::vector<Place>> chunks(divideUp(count, static_cast<std::size_t>(kPhotonsAtOnce)));
  forEachChunk(static_cast<std::int64_t>(count), kPhotonsAtOnce,
               [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
                 PairLists lists;
                 auto& places = chunks[static_cast<std::size_t>(chunk)];
                 places.reserve(static_cast<std::size_t>(2 * (end - begin)));
                 findPlaces(tree, photons, first + static_cast<std::size_t>(begin),
                            first + static_cast<std::size_t>(end), lists, places);
               });
  return sortPlaces(chunks, tileCount);
}

/// How many photons make a batch: as many as fill kBatchPlaces if all are like those looked at.
std::size_t batchSize(const BeamTreeView& tree, const PhotonPositions& photons) {
  PairLists lists;
  std::vector<Place> places;
  const std::size_t pilots = std::min(kPilotPhotons, photons.size());
  for (std::size_t i = 0; i < pilots; ++i) {
    const std::size_t photon = i * photons.size() / pilots;
    findPlaces(tree, photons, photon, photon + 1, lists, places);
  }
  const std::size_t fitting = kBatchPlaces * pilots / std::max<std::size_t>(1, places.size());
  return std::clamp<std::size_t>(fitting, 64, kBatchPlaces);
}

}  // namespace

BeamQuadtree::BeamQuadtree(std::span<const Beam> beams, Vec2i resolution) {
  for (const Beam& beam : beams) checkBeam(beam);
  build(beams, cellsOnImage(beams, resolution), {});
  boundTiles();
}

BeamQuadtree BeamQuadtree::inSpace(std::span<const Beam> beams) {
  for (const Beam& beam : beams) checkBeam(beam);
  const BeamPieces cut = cutBeams(beams);
  BeamQuadtree tree;
  tree.hasPieces_ = true;
  tree.build(cut.pieces, cellsInSpace(cut.pieces), cut.owners);
  tree.pieceStarts_.resize(tree.blocks_.size());
  for (std::size_t slot = 0; slot < tree.slotBeams_.size(); ++slot) {
    const std::uint32_t beam = tree.slotBeams_[slot];
    tree.pieceStarts_[slot / kLanes][slot % kLanes] = beam == kNoBeam ? kInfinity : beams[beam].t0;
  }
  tree.view_.pieceStarts = tree.pieceStarts_.data();
  tree.boundTiles();
  return tree;
}

void BeamQuadtree::build(std::span<const Beam> beams, const BeamCells& cells,
                         std::span<const std::uint32_t> owners) {
  blockBegin_.resize(cells.count() + 1, 0);
  for (std::size_t c = 0; c < cells.count(); ++c)
    blockBegin_[c + 1] = blockBegin_[c] + static_cast<std::uint32_t>(divideUp(
                                              cells.begin[c + 1] - cells.begin[c], kLanes));
  // Places without a beam hold one that contains nothing.
  Block none{};
  none.t0.fill(kInfinity);
  none.t1.fill(-kInfinity);
  blocks_.assign(blockBegin_.back(), none);
  slotBeams_.assign(blocks_.size() * kLanes, kNoBeam);

  std::vector<BeamFrustum> frusta(cells.count());
  forEachChunk(static_cast<std::int64_t>(cells.count()), kCellsAtOnce,
               [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                 for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end);
                      ++c)
                   frusta[c] = fillCell(c, beams, cells, owners);
               });
  buildLevels(std::move(frusta));
  view_.blocks = blocks_.data();
  view_.blockBegin = blockBegin_.data();
}

BeamFrustum BeamQuadtree::fillCell(std::size_t cell, std::span<const Beam> beams,
                                   const BeamCells& cells, std::span<const std::uint32_t> owners) {
  BeamFrustum all;
  std::uint32_t next = cells.begin[cell];
  for (std::uint32_t b = blockBegin_[cell]; b < blockBegin_[cell + 1]; ++b) {
    std::array<Beam, kLanes> inBlock;
    std::size_t n = 0;
    for (; n < kLanes && next < cells.begin[cell + 1]; ++n, ++next) {
      const std::uint32_t index = cells.order[next];
      inBlock[n] = beams[index];
      setBeam(blocks_[b], n, inBlock[n]);
      slotBeams_[b * kLanes + n] = owners.empty() ? index : owners[index];
    }
    const BeamFrustum bound = boundBeams({inBlock.data(), n});
    all = all.isEmpty() ? bound : boundFrusta(std::array{all, bound});
  }
  return all;
}

void BeamQuadtree::buildLevels(std::vector<BeamFrustum> frusta) {
  do {
    const std::size_t count = std::max<std::size_t>(1, divideUp(frusta.size(), kLanes));
    std::vector<Node>& nodes = levels_.emplace_back(count);
    std::vector<BeamFrustum> bounds(count);
    forEachChunk(static_cast<std::int64_t>(count), kCellsAtOnce,
                 [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                   for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end);
                        ++n) {
                     const std::size_t first = n * kLanes;
                     const std::size_t children = std::min(kLanes, frusta.size() - first);
                     for (std::size_t i = 0; i < kLanes; ++i)
                       setChild(nodes[n], i, i < children ? frusta[first + i] : BeamFrustum{});
                     bounds[n] = boundFrusta({frusta.data() + first, children});
                   }
                 });
    frusta = std::move(bounds);
  } while (frusta.size() > 1);
  view_.topLevel = static_cast<std::uint32_t>(levels_.size() - 1);
  while (view_.tileLevel < std::min(kMostTileLevel, view_.topLevel) &&
         levels_[view_.tileLevel + 1].size() >= kFewestTiles)
    ++view_.tileLevel;
  for (std::size_t i = 0; i < levels_.size(); ++i) view_.levels[i] = levels_[i].data();
}

void BeamQuadtree::boundTiles() {
  tileBounds_.resize(tileCount());
  forEachChunk(static_cast<std::int64_t>(tileCount()), 1,
               [&](std::int64_t, std::int64_t, std::int64_t chunk) {
                 const auto tile = static_cast<std::size_t>(chunk);
                 const BlockRange blocks = blocksOf(tile);
                 if (blocks.begin == blocks.end) return;
                 const Block& one = blocks_[blocks.begin];
                 const Vec3 origin(one.ox[0], one.oy[0], one.oz[0]);
                 BeamTreeView::Row first, last, radius2{}, away{};
                 first.fill(kInfinity);
                 last.fill(-kInfinity);
                 for (std::uint32_t b = blocks.begin; b < blocks.end; ++b) {
                   const Block& block = blocks_[b];
                   // Places without a beam start at infinity.
                   const BeamTreeView::Row& starts = view_.startsOf(b);
                   for (std::size_t i = 0; i < kLanes; ++i) {
                     const bool isBeam = starts[i] != kInfinity;
                     first[i] = std::min(first[i], starts[i]);
                     last[i] = std::max(last[i], isBeam ? starts[i] : -kInfinity);
                     radius2[i] = std::max(radius2[i], block.radius2[i]);
                     const float d = std::abs(block.ox[i] - origin.x) +
                                     std::abs(block.oy[i] - origin.y) +
                                     std::abs(block.oz[i] - origin.z);
                     away[i] = std::max(away[i], isBeam ? d : 0.f);
                   }
                 }
                 TileBounds& bounds = tileBounds_[tile];
                 bounds.starts = {*std::min_element(first.begin(), first.end()),
                                  *std::max_element(last.begin(), last.end())};
                 bounds.radius2 = *std::max_element(radius2.begin(), radius2.end());
                 if (*std::max_element(away.begin(), away.end()) == 0) bounds.origin = origin;
               });
}

BlockRange BeamQuadtree::blocksOf(std::size_t tile) const {
  const std::size_t cellCount = blockBegin_.size() - 1;
  const std::size_t cells = view_.cellsPerTile();
  return {blockBegin_[std::min(cellCount, tile * cells)],
          blockBegin_[std::min(cellCount, (tile + 1) * cells)]};
}

void BeamQuadtree::findPairs(const PhotonPositions& photons, Sink sink, void* context) const {
  forEachTile(photons, [&](std::size_t tile, std::span<const std::uint32_t> indices) {
    BeamPairBuffer found(sink, context);
    std::array<Vec3, kPhotonGroup> group;
    CellLists lists;
    for (; !indices.empty(); indices = indices.subspan(std::min(kPhotonGroup, indices.size()))) {
      const auto some = indices.first(std::min(kPhotonGroup, indices.size()));
      for (std::size_t i = 0; i < some.size(); ++i) group[i] = photons[some[i]];
      if (hasAvx2())
        avx2::findPairsInTile(view_, tile, {group.data(), some.size()}, some, lists, found);
      else
        generic::findPairsInTile(view_, tile, {group.data(), some.size()}, some, lists, found);
    }
    found.flush();
  });
}

void BeamQuadtree::forEachTile(const PhotonPositions& photons, const TileBody& body) const {
  BRUME_CHECK(photons.size() < kNoBeam);
  // The sums do not depend on the size of batches.
  const std::size_t batch = batchSize(view_, photons);
  for (std::size_t first = 0; first < photons.size(); first += batch) {
    const std::size_t count = std::min(batch, photons.size() - first);
    const PlacesByTile places = placesOf(view_, tileCount(), photons, first, count);
    forEachChunk(static_cast<std::int64_t>(tileCount()), 1,
                 [&](std::int64_t, std::int64_t, std::int64_t chunk) {
                   const auto tile = static_cast<std::size_t>(chunk);
                   const auto begin = places.begin[tile], end = places.begin[tile + 1];
                   if (begin < end) body(tile, {places.photons.data() + begin, end - begin});
                 });
  }
}

std::size_t BeamQuadtree::memoryBytes() const {
  std::size_t bytes = sizeof(*this) + blocks_.capacity() * sizeof(Block) +
                      pieceStarts_.capacity() * sizeof(BeamTreeView::Row) +
                      tileBounds_.capacity() * sizeof(TileBounds) +
                      (blockBegin_.capacity() + slotBeams_.capacity()) * sizeof(std::uint32_t);
  for (const auto& level : levels_) bytes += level.capacity() * sizeof(Node);
  return bytes;
}

}  // namespace brume
