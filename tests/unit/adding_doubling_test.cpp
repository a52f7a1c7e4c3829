// SPDX-License-Identifier: Apache-2.0
// The slab solver itself, against published and conserved values.
#include "support/adding_doubling.h"

#include <gtest/gtest.h>

#include <cmath>

namespace brume::test {
namespace {

struct Case {
  double albedo, g, tau, R[3], T[3];
};

// The table of the design (section 9); its first line is also in van de Hulst 1980.
constexpr Case kTable[] = {
    {0.9, 0.75, 2, {0.0974, 0.2336, 0.3969}, {0.6610, 0.4159, 0.2489}},
    {1, 0, 1, {0.3413, 0.4984, 0.6460}, {0.6587, 0.5016, 0.3540}},
    {1, 0, 16, {0.9036, 0.9333, 0.9519}, {0.0964, 0.0667, 0.0481}},
    {0.8, 0, 1, {0.2108, 0.3127, 0.4192}, {0.5414, 0.3504, 0.2045}},
    {0.99, 0.9, 10, {0.2476, 0.4364, 0.5997}, {0.5891, 0.3825, 0.2504}},
    {0.5, -0.5, 2, {0.1853, 0.2055, 0.2360}, {0.1617, 0.0418, 0.0156}},
};

TEST(AddingDoubling, ReproducesTheTable) {
  for (const Case& c : kTable) {
    const auto slab = solveSlab(c.albedo, c.tau, henyeyGreenstein(c.g), {1, 0.5, 0.2});
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(slab[i].R, c.R[i], 1e-4)
          << "albedo " << c.albedo << " g " << c.g << " tau " << c.tau;  // table: 4 digits
      EXPECT_NEAR(slab[i].T, c.T[i], 1e-4)
          << "albedo " << c.albedo << " g " << c.g << " tau " << c.tau;
    }
  }
}

TEST(AddingDoubling, ConservesEnergyAndMatchesVanDeHulst) {
  for (const SlabRadiance& s : solveSlab(1, 3, henyeyGreenstein(0.6), {1, 0.7, 0.1}))
    EXPECT_NEAR(s.R + s.T, 1, 1e-7);
  const auto s = solveSlab(0.9, 2, henyeyGreenstein(0.75), {1});
  EXPECT_NEAR(s[0].R, 0.09739, 1e-5);
  EXPECT_NEAR(s[0].T, 0.66096, 1e-5);
}

TEST(AddingDoubling, ThinSlabsInABeamScatterOnce) {
  // Isotropic: albedo / (4 pi) Int_0^tau exp(-t) exp(-t / mu0) dt, and so on for the dark side.
  constexpr double kAlbedo = 0.5, kTau = 1e-3, kPiDouble = 3.14159265358979323846;
  for (const SlabInBeam& s : solveSlabInBeams(kAlbedo, kTau, henyeyGreenstein(0))) {
    if (s.mu0 < 0.2) continue;  // the slab is not thin there
    const double k = 1 + 1 / s.mu0, d = 1 / s.mu0 - 1;
    EXPECT_NEAR(s.R, kAlbedo / (4 * kPiDouble) * -std::expm1(-k * kTau) / k, 4e-3 * s.R) << s.mu0;
    EXPECT_NEAR(s.T, kAlbedo / (4 * kPiDouble) * std::exp(-kTau) * -std::expm1(-d * kTau) / d,
                4e-3 * s.T)
        << s.mu0;
  }
}

}  // namespace
}  // namespace brume::test
