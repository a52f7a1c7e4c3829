// SPDX-License-Identifier: Apache-2.0
// Beams of a pinhole, looked up by projection: a photon is a splat on the image.
#pragma once

#include <span>
#include <vector>

#include "accelerators/beam_lookup.h"

namespace brume {

/// Beams that start at one point and keep to less than a half space, on a grid over a plane in
/// front of that point, about one beam per cell. The ball around a photon with the largest radius
/// of all beams covers, seen from the point, a rectangle of the plane (the bound of a
/// ball's projection, axis by axis); the beams of its cells are tested one by one. Good for equal
/// radii; a single large one makes every splat large.
class RasterBeams final : public BeamLookup {
 public:
  /// Whether all beams start at the same point, with t0 >= 0, and less than 80 degrees from their
  /// mean direction.
  static bool suits(std::span<const Beam> beams);

  /// Requires suits(beams).
  explicit RasterBeams(std::span<const Beam> beams);
  void findPairs(const PhotonPositions& photons, Sink sink, void* context) const override;
  std::size_t memoryBytes() const override;

 private:
  /// Cells [x0, x1] x [y0, y1]; empty when x0 > x1.
  struct Splat {
    std::uint32_t x0 = 1, x1 = 0, y0 = 1, y1 = 0;
  };
  Splat splatOf(const Vec3& photon) const;
  std::uint32_t column(double u) const;
  std::uint32_t row(double v) const;
  void buildGrid(std::span<const Beam> beams);

  std::vector<Beam> beams_;           // cell by cell
  std::vector<std::uint32_t> begin_;  // of each cell in beams_, and the end of the last
  Vec3 origin_{0};
  Frame frame_;  // z: the mean direction
  double largestRadius_ = 0;
  std::uint32_t columns_ = 1, rows_ = 1;
  Vec2d lo_{0}, perUnit_{0};  // of the plane z = 1
};

}  // namespace brume
