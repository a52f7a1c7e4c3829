// SPDX-License-Identifier: Apache-2.0
#include "volumes/slab_walk.h"

#include "core/cubic_density.h"
#include "core/lanes_double.h"

namespace brume {

namespace {

#define BRUME_KERNELS "volumes/slab_kernels.inl"
#include "core/both_lanes.inl"

/// The axis along which the ray passes the most cells.
std::size_t majorAxis(const Vec3d& d) {
  const Vec3d size = abs(d);
  return size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
}

std::int32_t cellAt(double w, std::int32_t last) {
  return static_cast<std::int32_t>(std::clamp(w, 0.0, double(last)));
}

}  // namespace

SlabWalk::SlabWalk(const DensityGrid& grid, const DensityGrid::LatticeRay& ray, double t0,
                   double t1)
    : grid_(grid) {
  if (!(t0 < t1) || grid.maxDensity() == 0) return;
  ray_.major = majorAxis(ray.d);
  ray_.minor = {(ray_.major + 1) % 3, (ray_.major + 2) % 3};
  ray_.length = t1 - t0;
  std::ptrdiff_t stride = 1;
  std::array<std::ptrdiff_t, 3> second{};
  for (int i = 0; i < 3; ++i) {
    const auto a = static_cast<std::size_t>(i);
    const std::int32_t n = grid.size()[a];
    ray_.o[a] = ray.o[i] + t0 * ray.d[i];
    ray_.d[a] = ray.d[i] == 0 ? 0 : ray.d[i];  // not -0
    ray_.step[a] = ray.d[i] > 0 ? 1 : ray.d[i] < 0 ? -1 : 0;
    ray_.edge[a] = ray.d[i] > 0 ? 1.f : ray.d[i] < 0 ? 0.f : 2.f;
    ray_.lastCell[a] = n;
    ray_.lastCorner[a] = std::max(n - 2, 0);
    ray_.widest[a] = n == 1 ? 0.f : 1.f;
    ray_.stride[a] = static_cast<double>(stride);
    second[a] = n == 1 ? 0 : stride;
    stride *= n;
  }
  const float* const voxels = grid.voxels();
  ray_.rows = {voxels, voxels + second[1], voxels + second[2], voxels + second[1] + second[2]};

  const std::size_t a = ray_.major;
  ray_.inverse = 1 / ray_.d[a];
  step_ = ray_.step[a] > 0 ? 1 : -1;
  slab_ = cellAt(ray_.o[a], grid.size()[a]);
  last_ = step_ * cellAt(ray_.o[a] + ray_.length * ray_.d[a], grid.size()[a]);
}

/// Of the layer of blocks that holds the next slab: what the ray meets of it from there on.
bool SlabWalk::isEmptyLayer(int level) const {
  const std::size_t major = ray_.major;
  const int shift = 3 * level;
  const auto layer = static_cast<std::int32_t>(slab_ >> shift);
  const auto t = [&](double plane) {
    return std::clamp((plane - ray_.o[major]) * ray_.inverse, 0.0, ray_.length);
  };
  const double t0 = t(double(slab_) + (step_ > 0 ? 0 : 1)),
               t1 = t(double((std::int64_t{layer} + (step_ > 0 ? 1 : 0)) << shift));
  // It is no wider than a block: it lies in four of them at most.
  DensityGrid::Cell lo, hi;
  for (const std::size_t a : ray_.minor) {
    const std::int32_t n = grid_.size()[a];
    lo[a] = cellAt(ray_.o[a] + t0 * ray_.d[a], n) >> shift;
    hi[a] = cellAt(ray_.o[a] + t1 * ray_.d[a], n) >> shift;
  }
  lo[major] = hi[major] = layer;
  DensityGrid::Cell mixed = lo, other = hi;
  std::swap(mixed[ray_.minor[0]], other[ray_.minor[0]]);
  return std::max({grid_.blockMax(level, lo), grid_.blockMax(level, hi),
                   grid_.blockMax(level, mixed), grid_.blockMax(level, other)}) == 0;
}

/// Moves slab_ to the next layer of blocks that holds something, if it is not in one.
bool SlabWalk::findOccupied() {
  while (slab_ * step_ <= last_) {
    int empty = 0;
    while (empty < grid_.levels() && isEmptyLayer(empty + 1)) ++empty;
    if (empty == 0) return true;
    const int shift = 3 * empty;
    const std::int64_t layer = slab_ >> shift;
    slab_ = step_ > 0 ? (layer + 1) << shift : (layer << shift) - 1;
  }
  return false;
}

void SlabWalk::lookAhead() {
  if (isAhead_ || !findOccupied()) return;
  SlabStretches& s = stretches_[1 - now_];
  if (hasAvx2())
    avx2::locate(ray_, slab_, s);
  else
    generic::locate(ray_, slab_, s);
  slabs_[1 - now_] = slab_;
  slab_ += step_ * static_cast<std::int64_t>(kLanes);
  isAhead_ = true;
  for (std::size_t i = 0; i < kLanes; ++i)
    for (const float* const row : ray_.rows) {
      __builtin_prefetch(row + s.index[0][i]);
      __builtin_prefetch(row + s.index[2][i]);
    }
}

bool SlabWalk::next() {
  lookAhead();
  if (!isAhead_) return false;
  now_ = 1 - now_;
  isAhead_ = false;
  return true;
}

SlabIntegrals SlabWalk::integrals() const {
  SlabIntegrals result;
  if (hasAvx2())
    avx2::integrate(ray_, stretches(), result);
  else
    generic::integrate(ray_, stretches(), result);
  return result;
}

void SlabWalk::findCubics(SlabCubics& cubics) const {
  if (hasAvx2()) return avx2::findCubics(ray_, stretches(), cubics);
  generic::findCubics(ray_, stretches(), cubics);
}

double integrateDensity(const DensityGrid& grid, const DensityGrid::LatticeRay& ray, double t0,
                        double t1) {
  SlabWalk walk(grid, ray, t0, t1);
  double sum = 0;
  while (walk.next()) {
    walk.lookAhead();
    for (const double inside : walk.integrals()) sum += inside;
  }
  return sum;
}

namespace {

/// The same as invertDensity() from cell to cell, in double; t1 when rounding leaves something.
double invertInCells(const DensityGrid& grid, const DensityGrid::LatticeRay& ray, double t0,
                     double t1, double target) {
  double result = t1;
  grid.walkCells(ray, t0, t1, [&](const DensityGrid::Cell& cell, double a, double b) {
    const MediumPiece piece{
        MediumPiece::Form::Cubic, a, b,
        DensityGrid::CellCorners(grid, cell)
            .bernstein(DensityGrid::inCell(ray, cell, a), DensityGrid::inCell(ray, cell, b)),
        nullptr};
    const double inside = piece.integral(a, b);
    if (inside < target) {
      target -= inside;
      return true;
    }
    result = a + invertCubic(piece, target, inside);
    return false;
  });
  return result;
}

}  // namespace

std::optional<double> invertDensity(const DensityGrid& grid, const DensityGrid::LatticeRay& ray,
                                    double t0, double t1, double target) {
  SlabWalk walk(grid, ray, t0, t1);
  double sum = 0;
  while (walk.next()) {
    // Most flights are short: the second eight slabs are not prepared before they are wanted.
    if (sum > 0) walk.lookAhead();
    const SlabIntegrals integrals = walk.integrals();
    for (std::size_t i = 0; i < kLanes; ++i) {
      if (sum + integrals[i] >= target) {
        const SlabStretches& s = walk.stretches();
        return invertInCells(grid, ray, t0 + s.start[i], std::min(t0 + s.end[i], t1), target - sum);
      }
      sum += integrals[i];
    }
  }
  return std::nullopt;
}

void appendCubics(const DensityGrid& grid, const DensityGrid::LatticeRay& ray, double t0, double t1,
                  std::vector<MediumPiece>& pieces) {
  SlabWalk walk(grid, ray, t0, t1);
  SlabCubics cubics;
  while (walk.next()) {
    walk.lookAhead();
    walk.findCubics(cubics);
    const SlabStretches& s = walk.stretches();
    for (std::size_t i = 0; i < kLanes; ++i) {
      const double length = s.end[i] - s.start[i];
      double from = t0 + s.start[i];
      for (std::size_t cell = 0; cell < 3; ++cell) {
        if (!(s.isUsed[cell] >> i & 1)) continue;
        // Ends are the starts of what follows, to the last bit.
        const double cut = cell < 2 ? double{s.cut[cell][i]} : 1;
        const double to =
            std::min(t0 + (cut < 1 ? std::min(s.start[i] + cut * length, s.end[i]) : s.end[i]), t1);
        const auto& c = cubics[cell];
        if (from < to && c[0][i] + c[1][i] + c[2][i] + c[3][i] > 0)
          pieces.push_back({MediumPiece::Form::Cubic,
                            from,
                            to,
                            {double{c[0][i]}, double{c[1][i]}, double{c[2][i]}, double{c[3][i]}},
                            nullptr});
        from = to;
      }
    }
  }
}

}  // namespace brume
