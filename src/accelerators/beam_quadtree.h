// SPDX-License-Identifier: Apache-2.0
// The beam hierarchy: photons find the beams they are inside of.
//
// Layout. Cells of a few pixels in Morton order are the leaves; 8 neighbouring cells make a node of
// the lowest level, 8 neighbouring nodes one of the next: a quadtree over the image whose levels
// are taken three halvings at a time, so that 8 children fill one vector. Children are found by
// index; there are no pointers. A node holds the frusta of its children (BeamFrustum); a cell
// without beams, or outside of the image, has an empty one. The beams of a cell stand in blocks of
// 8 in structure-of-arrays form. The size of a cell follows from the number of beams, so that most
// cells have one block.
//
// inSpace: the same tree for beams without order on the image (after mirrors and glass). Long beams
// are cut into pieces, disjoint by the float values of t; the pieces, halved again and again by the
// widest axis of their middles, take the places of the cells.
//
// A tile is a subtree of up to three levels. Photons are distributed to tiles in their order, then
// each tile is served by one task. docs/beam_quadtree.md says why and what it costs.
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "accelerators/beam_frustum.h"
#include "accelerators/beam_lookup.h"
#include "accelerators/beam_order.h"
#include "core/lanes.h"

namespace brume {

/// Blocks [begin, end).
struct BlockRange {
  std::uint32_t begin, end;
};

/// Photons that are searched for at once in a tile.
inline constexpr std::size_t kPhotonGroup = 16;
/// Places for pairs of these photons and cells of a tile, which has three levels at most.
inline constexpr std::size_t kCellPairs = (kPhotonGroup * kLanes * kLanes + 1) * kLanes;
struct CellLists {
  std::array<std::uint32_t, kCellPairs> now, next;
};

/// Two lists that take turns.
struct PairLists {
  std::vector<std::uint32_t> now, next;
};

/// What the kernels see.
struct BeamTreeView {
  using Row = std::array<float, kLanes>;
  /// The frusta of 8 children.
  struct alignas(32) Node {
    Row ax, ay, az, ux, uy, uz, s0, s1, r0, k;
  };
  /// 8 beams.
  struct alignas(32) Block {
    Row ox, oy, oz, dx, dy, dz, t0, t1, radius2, inverseRadius2;
  };
  static constexpr std::size_t kMaxLevels = 12;  // 8^12 > 2^32

  const Block* blocks = nullptr;
  const std::uint32_t* blockBegin = nullptr;     ///< of each cell, and the end of the last
  std::array<const Node*, kMaxLevels> levels{};  ///< the lowest first
  std::uint32_t topLevel = 0, tileLevel = 0;     ///< of the root; of the nodes that are tiles
  const Row* pieceStarts = nullptr;  ///< by block: t0 of the beam a piece is from; null: no pieces

  std::size_t cellsPerTile() const { return kLanes << 3 * tileLevel; }
  /// Where the beams of a block start, not their pieces; infinite where there is none.
  const Row& startsOf(std::uint32_t block) const {
    return pieceStarts ? pieceStarts[block] : blocks[block].t0;
  }
};

class BeamQuadtree final : public BeamLookup {
 public:
  /// Beam::pixel must be below the area of the resolution.
  BeamQuadtree(std::span<const Beam> beams, Vec2i resolution);
  static BeamQuadtree inSpace(std::span<const Beam> beams);
  BeamQuadtree(BeamQuadtree&&) = default;
  BeamQuadtree& operator=(BeamQuadtree&&) = default;

  void findPairs(const PhotonPositions& photons, Sink sink, void* context) const override;
  std::size_t memoryBytes() const override;

  const BeamTreeView& view() const { return view_; }
  std::size_t tileCount() const { return levels_[view_.tileLevel].size(); }
  /// The blocks of a tile; slot = 8 * block + lane.
  BlockRange blocksOf(std::size_t tile) const;
  /// What the beams of a tile have in common.
  struct TileBounds {
    /// The first and the last t at which they start; t0 > t1: no beams.
    Interval starts{kInfinity, -kInfinity};
    float radius2 = 0;           ///< the largest squared radius
    std::optional<Vec3> origin;  ///< of all of them, if it is the same
  };
  const TileBounds& boundsOf(std::size_t tile) const { return tileBounds_[tile]; }

  /// Calls body(tile, indices) for tiles and the photons that may be inside their beams, tiles in
  /// parallel, the photons of one tile in order, in one or several calls one after another.
  using TileBody =
      std::function<void(std::size_t tile, std::span<const std::uint32_t> photonIndices)>;
  void forEachTile(const PhotonPositions& photons, const TileBody& body) const;

 private:
  using Node = BeamTreeView::Node;
  using Block = BeamTreeView::Block;

  BeamQuadtree() = default;
  /// `owners`: the beam of each given one, where these are pieces; else empty.
  void build(std::span<const Beam> beams, const BeamCells& cells,
             std::span<const std::uint32_t> owners);
  BeamFrustum fillCell(std::size_t cell, std::span<const Beam> beams, const BeamCells& cells,
                       std::span<const std::uint32_t> owners);
  void buildLevels(std::vector<BeamFrustum> frusta);
  void boundTiles();

  std::vector<Block> blocks_;
  std::vector<std::uint32_t> blockBegin_;
  std::vector<std::vector<Node>> levels_;
  std::vector<BeamTreeView::Row> pieceStarts_;
  std::vector<TileBounds> tileBounds_;
  BeamTreeView view_;
};

}  // namespace brume
