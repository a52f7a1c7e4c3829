// SPDX-License-Identifier: Apache-2.0
// The order of beams in a tree: along a Morton curve over the image, or by halving space.
#pragma once

#include <span>
#include <vector>

#include "accelerators/beam_lookup.h"

namespace brume {

/// Items in cells: those of cell c are order[begin[c]] ... order[begin[c + 1] - 1].
struct BeamCells {
  std::vector<std::uint32_t> order, begin;
  std::size_t count() const { return begin.size() - 1; }
};

/// Position of a pixel on the Morton curve over 2^xBits * 2^yBits pixels: the bits of x and y in
/// turn, x first, while both have some, then the rest of the longer one.
std::uint64_t mortonIndex(std::uint32_t x, std::uint32_t y, int xBits, int yBits);

/// Cells along the Morton curve over the image, all of the same power of two of pixels, so many
/// that those with beams hold 8 or somewhat fewer on average. Empty beams are left out.
BeamCells cellsOnImage(std::span<const Beam> beams, Vec2i resolution);

/// Cells of up to 8 neighbours in space.
BeamCells cellsInSpace(std::span<const Beam> beams);

/// Beams, the long ones cut.
struct BeamPieces {
  std::vector<Beam> pieces;
  std::vector<std::uint32_t> owners;  ///< index of the beam a piece is from
};
/// Cuts beams so that there are some three pieces per beam, of about the same length. A float t
/// that lies in a beam lies in exactly one of its pieces. Empty beams are left out.
BeamPieces cutBeams(std::span<const Beam> beams);

}  // namespace brume
