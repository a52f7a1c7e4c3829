// SPDX-License-Identifier: Apache-2.0
// Walks of rays through a DensityGrid, eight slabs of cells at once.
//
// A slab is a layer of cells across the axis along which the ray runs fastest, counted in cells.
// Within it the ray changes its cell at most once along either other axis, so that it is in three
// cells at most: what stands in the way of vectors in a walk from cell to cell, that the next cell
// depends on this one, is gone. Slabs know nothing of each other: entry, cells, crossings, voxels
// and integrals of eight of them are found side by side, and they wait for memory together.
//
// Positions are found in double and kept, within their cell, in float; densities are interpolated
// in float, sums are doubles: integrals are exact to about 1e-7.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/lanes.h"
#include "core/volume.h"
#include "volumes/density_grid.h"

namespace brume {

/// A ray in lattice space (density_grid.h), from t = 0 to `length`, as the kernels want it.
struct SlabRay {
  std::size_t major = 0;                           ///< the axis across which slabs lie
  std::array<std::size_t, 2> minor{};              ///< the others
  std::array<double, 3> o{}, d{}, step{};          ///< step: sign of d
  double length = 0, inverse = 0;                  ///< inverse: 1 / d[major]
  std::array<float, 3> edge{};                     ///< where the ray leaves a cell; 2: never
  std::array<double, 3> lastCell{}, lastCorner{};  ///< lastCorner: of the low one of two voxels
  std::array<double, 3> stride{};                  ///< from voxel to voxel
  std::array<float, 3> widest{};  ///< last position between two voxels: 0 where there is but one
  std::array<const float*, 4> rows{};  ///< voxels at (y, z), (y + 1, z), (y, z + 1), (y + 1, z + 1)
};

/// One number for each of eight slabs.
using EightDoubles = std::array<double, kLanes>;
using EightFloats = std::array<float, kLanes>;

/// The ray's stretches in eight slabs: through three cells each, which end at fractions of the
/// stretch, 0 <= cut[0] <= cut[1] <= 1.
struct alignas(32) SlabStretches {
  EightDoubles start, end;  ///< t
  std::array<EightFloats, 2> cut;
  std::array<LaneMask, 3> isUsed;                         ///< the cell is not left at once
  std::array<std::array<std::int64_t, kLanes>, 3> index;  ///< per cell: its voxel of least x, y, z
  std::array<std::array<EightFloats, 3>, 3> position;     ///< per cell and axis: start, from there
  std::array<EightFloats, 3> change;                      ///< per axis: over the stretch
};
using SlabIntegrals = EightDoubles;
/// Bernstein coefficients for each of the three cells.
using SlabCubics = std::array<std::array<EightFloats, 4>, 3>;

/// The slabs along a ray from t0 to t1, eight at a time and in order, empty blocks left out.
class SlabWalk {
 public:
  SlabWalk(const DensityGrid& grid, const DensityGrid::LatticeRay& ray, double t0, double t1);

  /// Goes to the next eight slabs; false at the end.
  bool next();
  /// Finds those after them and asks memory for their voxels, for when they will be wanted.
  void lookAhead();
  /// Here t counts from t0.
  const SlabStretches& stretches() const { return stretches_[now_]; }
  /// Of the density over the stretches.
  SlabIntegrals integrals() const;
  void findCubics(SlabCubics& cubics) const;
  const SlabRay& ray() const { return ray_; }
  /// The first of the eight.
  std::int64_t slab() const { return slabs_[now_]; }

 private:
  bool isEmptyLayer(int level) const;
  bool findOccupied();

  const DensityGrid& grid_;
  SlabRay ray_;
  std::int64_t slab_ = 0, last_ = -1, step_ = 1;  // the next to be located; last_ along the step
  bool isAhead_ = false;
  std::size_t now_ = 0;
  std::array<SlabStretches, 2> stretches_;  // now, and ahead
  std::array<std::int64_t, 2> slabs_{};     // their first slabs
};

/// Int_t0^t1 density dt.
double integrateDensity(const DensityGrid& grid, const DensityGrid::LatticeRay& ray, double t0,
                        double t1);
/// The t with Int_t0^t density = target > 0; none when [t0, t1] holds less.
std::optional<double> invertDensity(const DensityGrid& grid, const DensityGrid::LatticeRay& ray,
                                    double t0, double t1, double target);
/// The cells along the ray as cubics, those without density left out.
void appendCubics(const DensityGrid& grid, const DensityGrid::LatticeRay& ray, double t0, double t1,
                  std::vector<MediumPiece>& pieces);

}  // namespace brume
