// SPDX-License-Identifier: Apache-2.0
// Infinite slabs 0 < z < 1 of media whose radiance adding-doubling knows: only the optical depth
// counts, so that the density may vary with z as it likes.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "support/adding_doubling.h"
#include "support/suite.h"

namespace brume::test {

/// A phase function as the scene language has it and as the solver has it.
struct PhaseCase {
  std::string name;
  std::string params;
  AnglePhase phase;
};
inline void PrintTo(const PhaseCase& c, std::ostream* out) { *out << c.name; }
/// Every phase function, and mixtures of them.
std::vector<PhaseCase> phaseCases();
PhaseCase henyeyGreensteinCase(double g);

/// How the slab is made of volumes; all have the optical depths of a homogeneous one.
enum class Build {
  Homogeneous,
  Exponential,  ///< falls by exp(-2) from z = 0 to 1
  Grid,         ///< layers of different density, one of them empty
  Split,        ///< two volumes, one on top of the other
  Overlap       ///< two volumes that fill the same space, with the coefficients 1 : 2
};
const char* nameOf(Build build);

/// Optical depth and albedo of each channel; what it emits per unit of absorption.
struct SlabMedium {
  std::array<double, 3> tau, albedo;
  PhaseCase phase;
  Build build = Build::Homogeneous;
  double emission = 0;  ///< Le = emission * sigma_a
};
std::string volumesOf(const SlabMedium& medium, double halfExtent);

/// The camera at cosine mu to the normal: on the lit side (z > 1), or on the dark one under the
/// slab.
std::string slabView(double mu, bool onLitSide);
/// The slab over a black floor that hides what comes from below.
SuiteScene slabScene(const Method& method, const std::string& volumes, const std::string& light,
                     double mu, bool onLitSide);

/// What a sky of radiance 1 on one side shows in each channel.
struct SlabColours {
  std::array<double, 3> R, T;
};
std::vector<SlabColours> solve(const SlabMedium& medium, const std::vector<double>& mus);

}  // namespace brume::test
