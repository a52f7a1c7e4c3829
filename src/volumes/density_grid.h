// SPDX-License-Identifier: Apache-2.0
// Trilinear density on a regular grid, and exact walks of rays through it.
//
// Lattice space: w = frac * n + 1/2 per axis, frac in [0, 1] across the box; voxel i has its centre
// at w = i + 1. Cell j of an axis (j = 0 ... n) is w in [j, j+1]; its ends are voxels j-1 and j,
// clamped to the grid, so the outer half voxels (the halves of cells 0 and n that lie in the box)
// are constant. In a cell the density along a ray is a cubic in t.
//
// Memory: the voxels as given, plus one float per block of 8^3, 64^3, ... cells: the largest
// density in it. Blocks where that is 0 are stepped over.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/math.h"
#include "core/rng.h"

namespace brume {

class DensityGrid {
 public:
  using Cell = std::array<std::int32_t, 3>;

  /// x fastest: voxels[(z * size[1] + y) * size[0] + x]. Values >= 0 and finite.
  DensityGrid(std::vector<float> voxels, const Cell& size);

  const Cell& size() const { return size_; }
  float maxDensity() const { return maxDensity_; }
  /// x fastest; where size()[0] is 1, one float more can be read.
  const float* voxels() const { return voxels_.data(); }
  /// Levels of blocks: of 8^level cells an axis, level = 1 ... levels().
  int levels() const { return static_cast<int>(levels_.size()); }
  /// The largest density in a block.
  float blockMax(int level, const Cell& block) const {
    const Level& l = levels_[static_cast<std::size_t>(level - 1)];
    return l
        .max[(static_cast<std::size_t>(block[2]) * l.size[1] + block[1]) * l.size[0] + block[0]];
  }
  /// At a point of lattice space; positions outside the box take the nearest value.
  double density(const Vec3d& w) const;
  /// Bytes beyond the voxels.
  std::size_t overheadBytes() const;

  /// A ray in lattice space, o + t d.
  struct LatticeRay {
    Vec3d o, d;
  };

  /// Calls visit(cell, t0, t1) for the cells along the ray between ta and tb, in order, leaving out
  /// blocks without density and stretches of no length; ends when visit returns false, and returns
  /// that. `finest` > 0 ends the descent at blocks of 8^finest cells.
  template <class Visit>
  bool walk(const LatticeRay& ray, double ta, double tb, int finest, Visit&& visit) const;
  /// The same for all cells, those without density as well: for short ways.
  template <class Visit>
  bool walkCells(const LatticeRay& ray, double ta, double tb, Visit&& visit) const {
    return walkLevel(ray, inverseOf(ray), 0, {0, 0, 0}, size_, ta, tb, 0, visit);
  }

  /// The densities at the corners of one cell.
  class CellCorners {
   public:
    CellCorners(const DensityGrid& grid, const Cell& cell);
    /// At the position f in [0, 1]^3.
    double at(const Vec3d& f) const;
    /// Bernstein coefficients of the density on the line from p to q (both in [0, 1]^3): the
    /// blossom of the trilinear function, all convex combinations of the corners.
    std::array<double, 4> bernstein(const Vec3d& p, const Vec3d& q) const;

   private:
    double v_[8];  // bit 0: x, bit 1: y, bit 2: z
  };

  /// Draws points of lattice space in proportion to the density. The interpolant is a sum of one
  /// tent per voxel, flattened at the borders, each of volume 1: a voxel is drawn by its value,
  /// then a point under its tent.
  class Sampler {
   public:
    explicit Sampler(const DensityGrid& grid);
    /// Sum of the voxels: Int density over the box, in lattice units.
    double total() const { return rowsUpTo_.back(); }
    Vec3d sample(const DensityGrid& grid, Rng& rng) const;

   private:
    std::vector<double> rowsUpTo_;  // sums of the voxels of all rows along x up to each
  };

  /// Position in a cell, clamped to it.
  static Vec3d inCell(const LatticeRay& ray, const Cell& cell, double t) {
    Vec3d f;
    for (int a = 0; a < 3; ++a)
      f[a] = std::clamp(ray.o[a] + t * ray.d[a] - double(cell[a]), 0.0, 1.0);
    return f;
  }

 private:
  struct Level {
    Cell size;               // in blocks
    std::vector<float> max;  // x fastest
  };

  static Vec3d inverseOf(const LatticeRay& ray) { return {1 / ray.d.x, 1 / ray.d.y, 1 / ray.d.z}; }
  template <class Visit>
  bool walkLevel(const LatticeRay& ray, const Vec3d& inverse, int level, const Cell& lo,
                 const Cell& hi, double ta, double tb, int finest, Visit&& visit) const;
  void buildFirstLevel();
  bool buildNextLevel();

  std::vector<float> voxels_;
  Cell size_;
  std::vector<Level> levels_;  // levels_[i]: blocks of 8^(i+1) cells
  float maxDensity_ = 0;
};

template <class Visit>
bool DensityGrid::walk(const LatticeRay& ray, double ta, double tb, int finest,
                       Visit&& visit) const {
  if (!(ta < tb) || maxDensity_ == 0) return true;
  const int top = static_cast<int>(levels_.size());
  const Cell hi{levels_.back().size[0] - 1, levels_.back().size[1] - 1, levels_.back().size[2] - 1};
  return walkLevel(ray, inverseOf(ray), top, {0, 0, 0}, hi, ta, tb, std::min(finest, top),
                   std::forward<Visit>(visit));
}

template <class Visit>
bool DensityGrid::walkLevel(const LatticeRay& ray, const Vec3d& inverse, int level, const Cell& lo,
                            const Cell& hi, double ta, double tb, int finest, Visit&& visit) const {
  // Start in the block that holds ray(ta). A start that rounding put one block off only makes a
  // stretch of length ~0, because crossings are ordered by their t alone and the index moves
  // strictly.
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double blockSize = static_cast<double>(std::int64_t{1} << (3 * level));
  Cell block, step;
  double next[3];
  const auto crossing = [&](int a) {
    if (step[a] == 0 || block[a] == (step[a] > 0 ? hi[a] : lo[a])) return kNever;
    const double plane = (block[a] + (step[a] > 0 ? 1 : 0)) * blockSize;
    return (plane - ray.o[a]) * inverse[a];
  };
  for (int a = 0; a < 3; ++a) {
    const double index = std::floor((ray.o[a] + ta * ray.d[a]) / blockSize);
    block[a] = static_cast<std::int32_t>(std::clamp(index, double(lo[a]), double(hi[a])));
    step[a] = ray.d[a] > 0 ? 1 : ray.d[a] < 0 ? -1 : 0;
    next[a] = crossing(a);
  }

  for (double t = ta;;) {
    const int axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
    const double end = std::min(std::max(next[axis], t), tb);
    if (end > t && (level == 0 || blockMax(level, block) > 0)) {
      if (level == finest) {
        if (!visit(block, t, end)) return false;
      } else {
        Cell childLo, childHi;
        for (int a = 0; a < 3; ++a) {
          const std::int32_t last =
              level == 1 ? size_[a] : levels_[static_cast<std::size_t>(level - 2)].size[a] - 1;
          childLo[a] = block[a] * 8;
          childHi[a] = std::min(block[a] * 8 + 7, last);
        }
        if (!walkLevel(ray, inverse, level - 1, childLo, childHi, t, end, finest, visit))
          return false;
      }
    }
    if (!(next[axis] < tb)) return true;
    t = end;
    block[axis] += step[axis];
    next[axis] = crossing(axis);
  }
}

}  // namespace brume
