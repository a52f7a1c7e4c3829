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
// A tile is the subtree of a node two levels above the blocks. Photons are distributed to tiles in
// their order, then each tile is served by one task.
#pragma once

#include <array>

#include "accelerators/beam_frustum.h"
#include "accelerators/beam_lookup.h"
#include "accelerators/beam_order.h"

namespace brume {

class BeamQuadtree final : public BeamLookup {
 public:
  static constexpr std::size_t kWidth = 8;
  /// The frusta of 8 children.
  struct alignas(32) Node {
    using Row = std::array<float, kWidth>;
    Row ax, ay, az, ux, uy, uz, s0, s1, r0, k;
  };
  /// 8 beams.
  struct alignas(32) Block {
    using Row = std::array<float, kWidth>;
    Row ox, oy, oz, dx, dy, dz, t0, t1, radius2;
  };

  /// Beam::pixel must be below the area of the resolution.
  BeamQuadtree(std::span<const Beam> beams, Vec2i resolution);
  static BeamQuadtree inSpace(std::span<const Beam> beams);

  void findPairs(const PhotonPositions& photons, Sink sink, void* context) const override;
  std::size_t memoryBytes() const override;
  std::size_t tileCount() const { return tileCount_; }

 private:
  BeamQuadtree() = default;
  /// `owners`: the beam of each given one, where these are pieces; else empty.
  void build(std::span<const Beam> beams, const BeamCells& cells,
             std::span<const std::uint32_t> owners);
  BeamFrustum fillCell(std::size_t cell, std::span<const Beam> beams, const BeamCells& cells,
                       std::span<const std::uint32_t> owners);
  void buildLevels(std::vector<BeamFrustum> frusta);
  /// Calls f(child) for the children of nodes of the level `lowest` below `node` that may contain
  /// p.
  template <class F>
  void descend(std::size_t level, std::size_t node, std::size_t lowest, const Vec3& p, F&& f) const;
  void findInTile(std::size_t tile, const Vec3& p, std::uint32_t photon,
                  BeamPairBuffer& found) const;
  /// Returns in how many tiles the photons had places.
  std::size_t findBatch(const PhotonPositions& photons, std::size_t first, std::size_t count,
                        Sink sink, void* context) const;

  std::vector<Block> blocks_;
  std::vector<std::uint32_t> blockBegin_;  ///< of each cell, and the end of the last
  std::vector<std::vector<Node>> levels_;  ///< the lowest first; the last has one node
  std::size_t tileLevel_ = 0;              ///< nodes of this level are tiles
  std::size_t tileCount_ = 0;
};

}  // namespace brume
