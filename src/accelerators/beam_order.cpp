// SPDX-License-Identifier: Apache-2.0
#include "accelerators/beam_order.h"

#include <bit>
#include <numeric>

#include "accelerators/kd_order.h"
#include "accelerators/photon_kdtree.h"
#include "core/error.h"

namespace brume {
namespace {

/// Beams in a block, and in a cell at best.
constexpr std::size_t kCellSize = 8;
/// Cells are made larger rather than more than this many times the beams.
constexpr std::uint64_t kCellsPerBeam = 8;
constexpr std::uint64_t kFewCells = 4096;
/// Pieces per beam in the mean, and at most for one beam.
constexpr double kMeanPieces = 3;
constexpr double kMostPieces = 256;
/// No cuts at smaller t: the processor may take denormal numbers for 0.
constexpr float kLeastCut = 1e-30f;

/// The lower 32 bits of v with a zero after each.
constexpr std::uint64_t spreadBits(std::uint64_t v) {
  v = (v | v << 16) & 0x0000ffff0000ffffull;
  v = (v | v << 8) & 0x00ff00ff00ff00ffull;
  v = (v | v << 4) & 0x0f0f0f0f0f0f0f0full;
  v = (v | v << 2) & 0x3333333333333333ull;
  return (v | v << 1) & 0x5555555555555555ull;
}

int bitsFor(int count) { return std::bit_width(static_cast<unsigned>(count - 1)); }

/// Counting sort of the beams that are not empty by `keys >> shift`.
BeamCells sortToCells(std::span<const Beam> beams, std::span<const std::uint64_t> keys, int shift,
                      std::size_t cellCount) {
  BeamCells cells;
  cells.begin.assign(cellCount + 1, 0);
  for (std::size_t i = 0; i < beams.size(); ++i)
    if (!beams[i].isEmpty()) ++cells.begin[(keys[i] >> shift) + 1];
  std::partial_sum(cells.begin.begin(), cells.begin.end(), cells.begin.begin());
  cells.order.resize(cells.begin.back());
  std::vector<std::uint32_t> next(cells.begin.begin(), cells.begin.end() - 1);
  for (std::size_t i = 0; i < beams.size(); ++i)
    if (!beams[i].isEmpty()) cells.order[next[keys[i] >> shift]++] = static_cast<std::uint32_t>(i);
  return cells;
}

/// Whether the cells that have beams have more of them than a block holds, in the mean.
bool areCrowded(const BeamCells& cells) {
  std::size_t used = 0;
  for (std::size_t c = 0; c < cells.count(); ++c) used += cells.begin[c + 1] > cells.begin[c];
  return cells.order.size() > kCellSize * used;
}

Vec3 middleOf(const Beam& beam) { return beam.o + (0.5f * (beam.t0 + beam.t1)) * beam.d; }

}  // namespace

std::uint64_t mortonIndex(std::uint32_t x, std::uint32_t y, int xBits, int yBits) {
  const int both = std::min(xBits, yBits);
  const std::uint32_t mask = static_cast<std::uint32_t>((std::uint64_t{1} << both) - 1);
  const std::uint64_t rest = xBits > yBits ? x >> both : y >> both;
  return spreadBits(x & mask) | spreadBits(y & mask) << 1 | (xBits != yBits ? rest << 2 * both : 0);
}

BeamCells cellsOnImage(std::span<const Beam> beams, Vec2i resolution) {
  BRUME_CHECK(resolution.x > 0 && resolution.y > 0);
  const auto width = static_cast<std::uint32_t>(resolution.x);
  const std::uint64_t pixels = std::uint64_t{width} * static_cast<std::uint64_t>(resolution.y);
  const int xBits = bitsFor(resolution.x), yBits = bitsFor(resolution.y), bits = xBits + yBits;

  std::vector<std::uint64_t> keys(beams.size());
  for (std::size_t i = 0; i < beams.size(); ++i) {
    BRUME_CHECK(beams[i].pixel < pixels);
    keys[i] = mortonIndex(beams[i].pixel % width, beams[i].pixel / width, xBits, yBits);
  }

  // Cells of 8 pixels; larger where there would be far more cells than beams, smaller where pixels
  // have several beams.
  int shift = std::min(3, bits);
  const std::uint64_t most = std::max(kFewCells, kCellsPerBeam * beams.size());
  while (std::uint64_t{1} << (bits - shift) > most) ++shift;
  BeamCells cells = sortToCells(beams, keys, shift, std::size_t{1} << (bits - shift));
  while (shift > 0 && areCrowded(cells) && std::uint64_t{2} << (bits - shift) <= most) {
    --shift;
    cells = sortToCells(beams, keys, shift, std::size_t{1} << (bits - shift));
  }
  return cells;
}

BeamCells cellsInSpace(std::span<const Beam> beams) {
  BeamCells cells;
  std::vector<std::uint32_t> used;
  std::vector<Vec3> middles;
  for (std::size_t i = 0; i < beams.size(); ++i) {
    if (beams[i].isEmpty()) continue;
    used.push_back(static_cast<std::uint32_t>(i));
    middles.push_back(middleOf(beams[i]));
  }
  cells.order = kdOrder(std::span<const Vec3>(middles));
  for (std::uint32_t& beam : cells.order) beam = used[beam];
  for (std::size_t i = 0; i < cells.order.size(); i += kCellSize)
    cells.begin.push_back(static_cast<std::uint32_t>(i));
  cells.begin.push_back(static_cast<std::uint32_t>(cells.order.size()));
  return cells;
}

BeamPieces cutBeams(std::span<const Beam> beams) {
  double total = 0;
  std::size_t used = 0;
  for (const Beam& beam : beams) {
    if (beam.isEmpty()) continue;
    total += double{beam.t1} - double{beam.t0};
    ++used;
  }
  // Each beam gets one piece, and the others go by length.
  const double piece = total / (std::max(1.0, static_cast<double>(used)) * (kMeanPieces - 1));

  BeamPieces result;
  const auto add = [&](const Beam& part, std::size_t owner) {
    result.pieces.push_back(part);
    result.owners.push_back(static_cast<std::uint32_t>(owner));
  };
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const Beam& beam = beams[i];
    if (beam.isEmpty()) continue;
    const double length = double{beam.t1} - double{beam.t0};
    const double cuts = piece > 0 ? std::min(kMostPieces, std::ceil(length / piece)) : 1;
    Beam part = beam;
    for (double n = 1; n < cuts; ++n) {
      // A piece ends just below where the next one begins.
      const auto next = static_cast<float>(double{beam.t0} + length * (n / cuts));
      part.t1 = std::nextafter(next, -kInfinity);
      if (!(part.t1 >= part.t0) || std::abs(next) < kLeastCut) continue;
      add(part, i);
      part.t0 = next;
    }
    part.t1 = beam.t1;
    add(part, i);
  }
  return result;
}

}  // namespace brume
