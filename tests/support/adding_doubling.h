// SPDX-License-Identifier: Apache-2.0
// An independent solver for plane-parallel slabs, against which renders are tested.
#pragma once

#include <functional>
#include <vector>

namespace brume::test {

/// Azimuthally averaged phase function: p0(mu, mu') = 1/(2 pi) Int p(cos angle) dphi, normalised to
/// Int_-1^1 p0 dmu = 2.
using AveragedPhase = std::function<double(double mu, double muPrime)>;
/// p as a function of the scattering angle's cosine, normalised to Int_-1^1 p dcos = 2.
using AnglePhase = std::function<double(double cosine)>;
/// By numerical integration over the azimuth.
AveragedPhase averaged(AnglePhase phase);
AnglePhase henyeyGreensteinOf(double g);
inline AveragedPhase henyeyGreenstein(double g) { return averaged(henyeyGreensteinOf(g)); }

/// What a slab under a uniform unit environment on one side shows at one angle.
struct SlabRadiance {
  double R = 0;  ///< seen from the lit side: plane albedo
  double T = 0;  ///< seen from the dark side: total transmittance, unscattered light included
};

/// Infinite index-matched slab by adding-doubling (van de Hulst 1980, chapter 5), for each mu =
/// cos(angle to the normal) in (0, 1]. Gauss-Legendre quadrature with `nodes` nodes; the asked
/// angles ride along with weight zero.
std::vector<SlabRadiance> solveSlab(double albedo, double opticalThickness,
                                    const AveragedPhase& phase, const std::vector<double>& mus,
                                    int nodes = 32);

/// The slab in parallel light: what it shows along its normal (mu = 1).
struct SlabInBeam {
  double mu0 = 0;  ///< cosine between the light's direction and the normal
  double R = 0;    ///< radiance on the lit side for an irradiance of 1 across the beam
  double T = 0;    ///< on the dark side, the same
};
/// For the directions of the quadrature's nodes, which is where the solver knows fluxes.
std::vector<SlabInBeam> solveSlabInBeams(double albedo, double opticalThickness,
                                         const AveragedPhase& phase, int nodes = 32);

}  // namespace brume::test
