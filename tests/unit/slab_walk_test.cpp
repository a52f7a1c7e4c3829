// SPDX-License-Identifier: Apache-2.0
#include "volumes/slab_walk.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/lanes_double.h"
#include "core/medium_along_ray.h"
#include "support/volumes.h"

namespace brume {
namespace {

#define BRUME_KERNELS "volumes/slab_kernels.inl"
#include "core/both_lanes.inl"

using Cell = DensityGrid::Cell;
using LatticeRay = DensityGrid::LatticeRay;

const std::array<Cell, 7> kSizes = {Cell{1, 1, 1}, {2, 1, 3},   {1, 5, 4},   {5, 4, 1},
                                    {9, 17, 8},    {40, 3, 70}, {24, 40, 33}};

DensityGrid makeDensities(const Cell& n, Rng& rng, float empty = .3f) {
  return DensityGrid(test::randomDensities(std::size_t(n[0]) * n[1] * n[2], rng, empty), n);
}

struct Chord {
  LatticeRay ray;
  double t0, t1;
};

/// Chords of the grid's box in lattice space, many of them along faces, edges and planes of voxels
/// or through corners; some begin or end inside.
std::vector<Chord> nastyChords(const Cell& n, Rng& rng, int count) {
  const auto place = [&](std::size_t a) {
    const std::uint32_t kind = rng.below(4);
    if (kind == 0) return 0.5 + n[a] * rng.uniformDouble();
    if (kind == 1) return 1.0 + rng.below(static_cast<std::uint32_t>(n[a]));  // a plane of voxels
    if (kind == 2) return rng.below(2) ? 0.5 : n[a] + 0.5;                    // a face
    return 0.5 + rng.below(static_cast<std::uint32_t>(n[a]) + 1);
  };
  std::vector<Chord> chords;
  while (chords.size() < static_cast<std::size_t>(count)) {
    const Vec3d p(place(0), place(1), place(2));
    Vec3d q(place(0), place(1), place(2));
    for (int a = 0; a < 3; ++a)
      if (rng.below(4) == 0) q[a] = p[a];
    if (p == q) continue;
    // The origin lies anywhere on the line.
    const double scale = std::exp(20 * (rng.uniformDouble() - 0.5)), at = rng.below(3) * 1.7;
    const Vec3d d = (q - p) / scale;
    chords.push_back({{p - at * scale * d, d}, at * scale, (at + 1) * scale});
  }
  return chords;
}

/// The same from cell to cell, in double.
double slowIntegral(const DensityGrid& grid, const Chord& chord) {
  double sum = 0;
  grid.walk(chord.ray, chord.t0, chord.t1, 0, [&](const Cell& cell, double t0, double t1) {
    const DensityGrid::CellCorners corners(grid, cell);
    const double middle = 0.5 * (t0 + t1), half = 0.5 * (t1 - t0);
    for (const double t : {middle - half * kGauss2, middle + half * kGauss2})
      sum += half * corners.at(DensityGrid::inCell(chord.ray, cell, t));
    return true;
  });
  return sum;
}

TEST(SlabWalk, IntegratesAsTheWalkFromCellToCell) {
  Rng rng(1);
  for (const Cell& n : kSizes) {
    const DensityGrid grid = makeDensities(n, rng);
    for (const Chord& chord : nastyChords(n, rng, 2000)) {
      const double expected = slowIntegral(grid, chord);
      // Positions in a cell are floats: 6e-8 of it, against densities up to maxDensity().
      const double tolerance =
          3e-7 * expected + 2e-7 * double{grid.maxDensity()} * (chord.t1 - chord.t0);
      ASSERT_NEAR(integrateDensity(grid, chord.ray, chord.t0, chord.t1), expected, tolerance);
    }
  }
}

TEST(SlabWalk, RelativeErrorsOfDenseGridsAreThoseOfFloats) {
  // However short the stretch is.
  Rng rng(2);
  for (const Cell& n : kSizes) {
    std::vector<float> densities(static_cast<std::size_t>(n[0]) * n[1] * n[2]);
    for (float& d : densities) d = .5f + rng.uniform();
    const DensityGrid grid(densities, n);
    for (Chord chord : nastyChords(n, rng, 1000)) {
      const double length = chord.t1 - chord.t0;
      chord.t0 += 0.3 * rng.uniformDouble() * length;
      chord.t1 = chord.t0 + length * std::exp(-14 * rng.uniformDouble()) * 0.7;
      const double expected = slowIntegral(grid, chord);
      ASSERT_NEAR(integrateDensity(grid, chord.ray, chord.t0, chord.t1), expected, 3e-7 * expected);
    }
  }
}

TEST(SlabWalk, CubicsHoldTheSame) {
  Rng rng(3);
  for (const Cell& n : kSizes) {
    const DensityGrid grid = makeDensities(n, rng);
    std::vector<MediumPiece> pieces;
    for (const Chord& chord : nastyChords(n, rng, 1000)) {
      pieces.clear();
      appendCubics(grid, chord.ray, chord.t0, chord.t1, pieces);
      double sum = 0, last = chord.t0;
      for (const MediumPiece& p : pieces) {
        ASSERT_GE(p.t0, last);
        ASSERT_GT(p.t1, p.t0);
        ASSERT_LE(p.t1, chord.t1);
        last = p.t1;
        sum += p.integral(p.t0, p.t1);
        // The middle, in the cell's own position: a crossing may lie 1e-7 of a cell off.
        const double t = 0.5 * (p.t0 + p.t1);
        ASSERT_NEAR(p.density(t), grid.density(chord.ray.o + t * chord.ray.d),
                    1e-6 * double{grid.maxDensity()});
      }
      const double tolerance = 2e-7 * double{grid.maxDensity()} * (chord.t1 - chord.t0);
      const double expected = slowIntegral(grid, chord);
      ASSERT_NEAR(sum, expected, 3e-7 * expected + tolerance);
    }
  }
}

TEST(SlabWalk, InversionIsTheInverse) {
  Rng rng(4);
  for (const Cell& n : kSizes) {
    const DensityGrid grid = makeDensities(n, rng);
    for (const Chord& chord : nastyChords(n, rng, 1000)) {
      const auto [ray, t0, t1] = chord;
      const double total = integrateDensity(grid, ray, t0, t1);
      EXPECT_FALSE(invertDensity(grid, ray, t0, t1, total * (1 + 1e-6) + 1e-300));
      if (total == 0) continue;
      const double target = total * (0.001 + 0.998 * rng.uniformDouble());
      const auto t = invertDensity(grid, ray, t0, t1, target);
      ASSERT_TRUE(t);
      ASSERT_GE(*t, t0);
      ASSERT_LE(*t, t1);
      ASSERT_NEAR(integrateDensity(grid, ray, t0, *t), target,
                  3e-7 * total + 2e-7 * double{grid.maxDensity()} * (t1 - t0));
    }
  }
}

TEST(SlabWalk, DensitiesOfAllMagnitudesKeepTheirs) {
  // Along an axis the densities between the rows do not mix: what is 0, denormal or 1e10 beside a
  // row leaves it alone.
  constexpr std::int32_t n = 12;
  std::vector<float> densities(n * n * n);
  for (std::size_t i = 0; i < densities.size(); ++i) {
    const std::size_t row = i / n;
    densities[i] = row % 4 == 0 ? 0 : row % 4 == 1 ? 1e-40f : row % 4 == 2 ? 1e10f : 1;
  }
  const DensityGrid grid(densities, {n, n, n});
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (const double sign : {1.0, -1.0}) {
        const double density = double{densities[std::size_t(z * n + y) * n]};
        const LatticeRay ray{{sign > 0 ? 0.5 : n + 0.5, y + 1.0, z + 1.0}, {sign, 0, 0}};
        EXPECT_NEAR(integrateDensity(grid, ray, 0, n), n * density, 3e-7 * n * density);
        const auto t = invertDensity(grid, ray, 0, n, density > 0 ? 4.25 * density : 1e-300);
        ASSERT_EQ(t.has_value(), density > 0) << density;
        EXPECT_NEAR(t.value_or(4.25), 4.25, 1e-5);
      }
}

TEST(SlabWalk, StepsOverEmptyBlocks) {
  constexpr int n = 512;
  std::vector<float> densities(std::size_t(n) * n * n / 8);
  const Cell size{n, n / 4, n / 2};
  for (int x = 340; x < 350; ++x) densities[(std::size_t(100) * size[1] + 50) * n + x] = 1;
  const DensityGrid grid(densities, size);
  for (const double sign : {1.0, -1.0}) {
    const LatticeRay ray{{sign > 0 ? 0.5 : n + 0.5, 51.25, 101}, {sign, 1e-4, -1e-4}};
    SlabWalk walk(grid, ray, 0, n);
    int batches = 0;
    while (walk.next()) ++batches;
    EXPECT_GE(batches, 2);
    EXPECT_LE(batches, 3);  // 336 ... 351, and what eight slabs reach beyond
    const double expected = slowIntegral(grid, {ray, 0, n});
    EXPECT_GT(expected, 6);
    EXPECT_NEAR(integrateDensity(grid, ray, 0, n), expected, 3e-7 * expected);
  }
}

TEST(SlabWalk, SparseGridsLoseNothing) {
  Rng rng(7);
  const Cell n{72, 100, 64};
  std::vector<float> densities(static_cast<std::size_t>(n[0]) * n[1] * n[2]);
  for (int i = 0; i < 40; ++i)
    densities[rng.below(static_cast<std::uint32_t>(densities.size()))] = 1 + rng.uniform();
  const DensityGrid grid(densities, n);
  int met = 0;
  for (const Chord& chord : nastyChords(n, rng, 20'000)) {
    const double expected = slowIntegral(grid, chord);
    met += expected > 0;
    ASSERT_NEAR(integrateDensity(grid, chord.ray, chord.t0, chord.t1), expected,
                3e-7 * expected + 2e-8 * (chord.t1 - chord.t0));
  }
  EXPECT_GT(met, 200);
}

TEST(SlabWalk, BothKindsOfLanesGiveTheSameBits) {
  if (!hasAvx2()) GTEST_SKIP() << "this machine has no AVX2";
  Rng rng(6);
  for (const Cell& n : kSizes) {
    const DensityGrid grid = makeDensities(n, rng);
    for (const Chord& chord : nastyChords(n, rng, 500)) {
      SlabWalk walk(grid, chord.ray, chord.t0, chord.t1);
      while (walk.next()) {
        SlabStretches a, b;
        std::memset(&a, 0, sizeof(a));
        std::memset(&b, 0, sizeof(b));
        generic::locate(walk.ray(), walk.slab(), a);
        avx2::locate(walk.ray(), walk.slab(), b);
        ASSERT_EQ(std::memcmp(&a, &b, sizeof(a)), 0);
        SlabIntegrals sumsA, sumsB;
        generic::integrate(walk.ray(), a, sumsA);
        avx2::integrate(walk.ray(), a, sumsB);
        ASSERT_EQ(std::memcmp(&sumsA, &sumsB, sizeof(sumsA)), 0);
        SlabCubics cubicsA{}, cubicsB{};
        generic::findCubics(walk.ray(), a, cubicsA);
        avx2::findCubics(walk.ray(), a, cubicsB);
        ASSERT_EQ(std::memcmp(&cubicsA, &cubicsB, sizeof(cubicsA)), 0);
      }
    }
  }
}

}  // namespace
}  // namespace brume
