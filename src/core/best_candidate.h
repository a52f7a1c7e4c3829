// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "core/sampler.h"

namespace brume {

/// A set of 4096 points on the torus [0, 1)^2 that keep their distance from each other, each with a
/// time and a lens position unlike those of its neighbours. Generated at construction (a few
/// milliseconds), always the same. Source: Mitchell 1991, Spectrally Optimal Sampling.
///
/// Memory: the points are sorted by the cells of a 64 x 64 grid, row by row; cellStart_[c] is the
/// first point of cell c, so the points of a rectangle are found without a search.
class BestCandidatePattern {
 public:
  static constexpr int kGrid = 64;
  static constexpr int kCount = kGrid * kGrid;
  struct Point {
    Vec2 position{0};  ///< on the torus
    Vec2 lens{0};
    float time = 0;
  };

  BestCandidatePattern();
  /// Points of the cells that touch the rectangle [lo, hi] within [0, 1]^2, cell by cell: a
  /// superset of those inside. Calls visit(point).
  template <class Visit>
  void forEachNear(Vec2 lo, Vec2 hi, const Visit& visit) const {
    const auto cell = [](float x) { return std::clamp(static_cast<int>(x * kGrid), 0, kGrid - 1); };
    for (int y = cell(lo.y); y <= cell(hi.y); ++y) {
      const std::size_t row = static_cast<std::size_t>(y) * kGrid;
      for (std::uint32_t i = cellStart_[row + static_cast<std::size_t>(cell(lo.x))];
           i < cellStart_[row + static_cast<std::size_t>(cell(hi.x)) + 1]; ++i)
        visit(points_[i]);
    }
  }
  const std::vector<Point>& points() const { return points_; }

 private:
  void sortByCell();
  void assignTimesAndLenses();

  std::vector<Point> points_;
  std::array<std::uint32_t, kCount + 1> cellStart_{};
};

}  // namespace brume
