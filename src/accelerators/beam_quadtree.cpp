// SPDX-License-Identifier: Apache-2.0
#include "accelerators/beam_quadtree.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

#include "accelerators/beam_order.h"
#include "core/error.h"
#include "core/parallel.h"

namespace brume {
namespace {

constexpr std::size_t kWidth = BeamQuadtree::kWidth;
/// Level whose nodes are tiles, where the tree is so high: 64 cells, 512 beams.
constexpr std::size_t kTileLevel = 1;
/// Cells or nodes that one task of the build bounds.
constexpr std::int64_t kCellsAtOnce = 512;
/// Photons that one task distributes to tiles.
constexpr std::int64_t kPhotonsAtOnce = 512;
/// Photons of the first batch, and places in tiles that a batch aims at: a bound on memory.
constexpr std::size_t kFirstBatch = 4096;
constexpr std::size_t kBatchPlaces = std::size_t{1} << 21;

std::size_t divideUp(std::size_t a, std::size_t b) { return (a + b - 1) / b; }

void setChild(BeamQuadtree::Node& node, std::size_t i, const BeamFrustum& f) {
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

void setBeam(BeamQuadtree::Block& block, std::size_t i, const Beam& beam) {
  block.ox[i] = beam.o.x;
  block.oy[i] = beam.o.y;
  block.oz[i] = beam.o.z;
  block.dx[i] = beam.d.x;
  block.dy[i] = beam.d.y;
  block.dz[i] = beam.d.z;
  block.t0[i] = beam.t0;
  block.t1[i] = beam.t1;
  block.radius2[i] = sqr(beam.radius);
}

/// Bit i: child i may contain p.
std::uint32_t childrenWith(const BeamQuadtree::Node& node, const Vec3& p) {
  std::uint32_t mask = 0;
  for (std::size_t i = 0; i < kWidth; ++i) {
    const auto foot = beamFoot<float>(node.ax[i], node.ay[i], node.az[i], node.ux[i], node.uy[i],
                                      node.uz[i], p.x, p.y, p.z);
    const bool hit = (foot.t >= node.s0[i]) & (foot.t <= node.s1[i]) &
                     (foot.d2 <= sqr(node.r0[i] + node.k[i] * foot.t));
    mask |= std::uint32_t{hit} << i;
  }
  return mask;
}

/// A photon's place in a tile.
struct Place {
  std::uint32_t tile, photon;
};

/// The places of a batch, by tile, photons in their order.
struct PlacesByTile {
  std::vector<std::uint32_t> begin, photons;
};

PlacesByTile sortPlaces(const std::vector<std::vector<Place>>& chunks, std::size_t tileCount) {
  PlacesByTile sorted;
  sorted.begin.assign(tileCount + 1, 0);
  for (const auto& chunk : chunks)
    for (const Place& place : chunk) ++sorted.begin[place.tile + 1];
  std::partial_sum(sorted.begin.begin(), sorted.begin.end(), sorted.begin.begin());
  sorted.photons.resize(sorted.begin.back());
  std::vector<std::uint32_t> next(sorted.begin.begin(), sorted.begin.end() - 1);
  for (const auto& chunk : chunks)
    for (const Place& place : chunk) sorted.photons[next[place.tile]++] = place.photon;
  return sorted;
}

}  // namespace

BeamQuadtree::BeamQuadtree(std::span<const Beam> beams, Vec2i resolution) {
  for (const Beam& beam : beams) checkBeam(beam);
  build(beams, cellsOnImage(beams, resolution), {});
}

BeamQuadtree BeamQuadtree::inSpace(std::span<const Beam> beams) {
  for (const Beam& beam : beams) checkBeam(beam);
  const BeamPieces cut = cutBeams(beams);
  BeamQuadtree tree;
  tree.hasPieces_ = true;
  tree.build(cut.pieces, cellsInSpace(cut.pieces), cut.owners);
  return tree;
}

void BeamQuadtree::build(std::span<const Beam> beams, const BeamCells& cells,
                         std::span<const std::uint32_t> owners) {
  blockBegin_.resize(cells.count() + 1, 0);
  for (std::size_t c = 0; c < cells.count(); ++c)
    blockBegin_[c + 1] = blockBegin_[c] + static_cast<std::uint32_t>(divideUp(
                                              cells.begin[c + 1] - cells.begin[c], kWidth));
  // Places without a beam hold one that contains nothing.
  Block none{};
  none.t0.fill(kInfinity);
  none.t1.fill(-kInfinity);
  blocks_.assign(blockBegin_.back(), none);
  slotBeams_.assign(blocks_.size() * kWidth, kNoBeam);

  std::vector<BeamFrustum> frusta(cells.count());
  forEachChunk(static_cast<std::int64_t>(cells.count()), kCellsAtOnce,
               [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                 for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end);
                      ++c)
                   frusta[c] = fillCell(c, beams, cells, owners);
               });
  buildLevels(std::move(frusta));
}

BeamFrustum BeamQuadtree::fillCell(std::size_t cell, std::span<const Beam> beams,
                                   const BeamCells& cells, std::span<const std::uint32_t> owners) {
  BeamFrustum all;
  std::uint32_t next = cells.begin[cell];
  for (std::uint32_t b = blockBegin_[cell]; b < blockBegin_[cell + 1]; ++b) {
    std::array<Beam, kWidth> inBlock;
    std::size_t n = 0;
    for (; n < kWidth && next < cells.begin[cell + 1]; ++n, ++next) {
      const std::uint32_t index = cells.order[next];
      inBlock[n] = beams[index];
      setBeam(blocks_[b], n, inBlock[n]);
      slotBeams_[b * kWidth + n] = owners.empty() ? index : owners[index];
    }
    const BeamFrustum bound = boundBeams({inBlock.data(), n});
    all = all.isEmpty() ? bound : boundFrusta(std::array{all, bound});
  }
  return all;
}

void BeamQuadtree::buildLevels(std::vector<BeamFrustum> frusta) {
  do {
    const std::size_t count = std::max<std::size_t>(1, divideUp(frusta.size(), kWidth));
    std::vector<Node>& nodes = levels_.emplace_back(count);
    std::vector<BeamFrustum> bounds(count);
    forEachChunk(static_cast<std::int64_t>(count), kCellsAtOnce,
                 [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                   for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end);
                        ++n) {
                     const std::size_t first = n * kWidth;
                     const std::size_t children = std::min(kWidth, frusta.size() - first);
                     for (std::size_t i = 0; i < kWidth; ++i)
                       setChild(nodes[n], i, i < children ? frusta[first + i] : BeamFrustum{});
                     bounds[n] = boundFrusta({frusta.data() + first, children});
                   }
                 });
    frusta = std::move(bounds);
  } while (frusta.size() > 1);
  tileLevel_ = std::min(kTileLevel, levels_.size() - 1);
  tileCount_ = levels_[tileLevel_].size();
}

template <class F>
void BeamQuadtree::descend(std::size_t level, std::size_t node, std::size_t lowest, const Vec3& p,
                           F&& f) const {
  std::uint32_t mask = childrenWith(levels_[level][node], p);
  for (; mask != 0; mask &= mask - 1) {
    const std::size_t child = node * kWidth + static_cast<std::size_t>(std::countr_zero(mask));
    if (level == lowest)
      f(child);
    else
      descend(level - 1, child, lowest, p, f);
  }
}

void BeamQuadtree::findInTile(std::size_t tile, const Vec3& p, std::uint32_t photon,
                              BeamPairBuffer& found) const {
  descend(tileLevel_, tile, 0, p, [&](std::size_t cell) {
    for (std::uint32_t b = blockBegin_[cell]; b < blockBegin_[cell + 1]; ++b) {
      const Block& block = blocks_[b];
      for (std::size_t i = 0; i < kWidth; ++i) {
        const auto foot = beamFoot<float>(block.ox[i], block.oy[i], block.oz[i], block.dx[i],
                                          block.dy[i], block.dz[i], p.x, p.y, p.z);
        if (isInBeam(foot, {block.t0[i], block.t1[i]}, block.radius2[i]))
          found.add(static_cast<std::uint32_t>(b * kWidth + i), photon, foot);
      }
    }
  });
}

void BeamQuadtree::findPairs(const PhotonPositions& photons, Sink sink, void* context) const {
  std::size_t batch = kFirstBatch;
  for (std::size_t first = 0; first < photons.size();) {
    const std::size_t count = std::min(batch, photons.size() - first);
    const std::size_t places = findBatch(photons, first, count, sink, context);
    first += count;
    // As many photons as would have filled the places; the sums do not depend on it.
    batch = std::clamp<std::size_t>(count * kBatchPlaces / std::max<std::size_t>(1, places), 64,
                                    2 * kBatchPlaces);
  }
}

std::size_t BeamQuadtree::findBatch(const PhotonPositions& photons, std::size_t first,
                                    std::size_t count, Sink sink, void* context) const {
  const auto at = [&](std::size_t i) { return Vec3(photons.x[i], photons.y[i], photons.z[i]); };
  std::vector<std::vector<Place>> chunks(divideUp(count, static_cast<std::size_t>(kPhotonsAtOnce)));
  forEachChunk(static_cast<std::int64_t>(count), kPhotonsAtOnce,
               [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
                 auto& places = chunks[static_cast<std::size_t>(chunk)];
                 for (std::int64_t i = begin; i < end; ++i) {
                   const auto photon =
                       static_cast<std::uint32_t>(first + static_cast<std::size_t>(i));
                   const auto put = [&](std::size_t tile) {
                     places.push_back({static_cast<std::uint32_t>(tile), photon});
                   };
                   if (levels_.size() - 1 == tileLevel_)
                     put(0);
                   else
                     descend(levels_.size() - 1, 0, tileLevel_ + 1, at(photon), put);
                 }
               });
  const PlacesByTile places = sortPlaces(chunks, tileCount_);
  forEachChunk(static_cast<std::int64_t>(tileCount_), 1,
               [&](std::int64_t, std::int64_t, std::int64_t chunk) {
                 const auto tile = static_cast<std::size_t>(chunk);
                 if (places.begin[tile] == places.begin[tile + 1]) return;
                 BeamPairBuffer found(sink, context);
                 for (std::uint32_t i = places.begin[tile]; i < places.begin[tile + 1]; ++i)
                   findInTile(tile, at(places.photons[i]), places.photons[i], found);
                 found.flush();
               });
  return places.photons.size();
}

std::size_t BeamQuadtree::memoryBytes() const {
  std::size_t bytes = sizeof(*this) + blocks_.capacity() * sizeof(Block) +
                      (blockBegin_.capacity() + slotBeams_.capacity()) * sizeof(std::uint32_t);
  for (const auto& level : levels_) bytes += level.capacity() * sizeof(Node);
  return bytes;
}

}  // namespace brume
