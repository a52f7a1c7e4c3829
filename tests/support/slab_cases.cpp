// SPDX-License-Identifier: Apache-2.0
#include "support/slab_cases.h"

#include <fmt/format.h>

#include <cmath>

namespace brume::test {

namespace {

AnglePhase schlick(double k) {
  return [k](double c) { return (1 - k * k) / ((1 - k * c) * (1 - k * c)); };
}
AnglePhase mie(int n) {
  return [n](double c) { return 0.5 + 0.5 * (n + 1) * std::pow(0.5 * (1 + c), n); };
}
AnglePhase rayleigh() {
  return [](double c) { return 0.75 * (1 + c * c); };
}
AnglePhase mixed(double w, AnglePhase a, AnglePhase b) {
  return [=](double c) { return w * a(c) + (1 - w) * b(c); };
}

std::array<double, 3> operator*(const std::array<double, 3>& a, double s) {
  return {a[0] * s, a[1] * s, a[2] * s};
}

struct Coefficients {
  std::array<double, 3> sigma_a, sigma_s, Le;
};
Coefficients coefficientsOf(const SlabMedium& m) {
  Coefficients k;
  for (std::size_t c = 0; c < 3; ++c) {
    k.sigma_a[c] = m.tau[c] * (1 - m.albedo[c]);
    k.sigma_s[c] = m.tau[c] * m.albedo[c];
    k.Le[c] = m.emission * k.sigma_a[c];
  }
  return k;
}

std::string volume(const std::string& kind, const SlabMedium& m, double half, double z0, double z1,
                   double scale, const std::string& params = "") {
  const Coefficients k = coefficientsOf(m);
  return fmt::format(
      "Volume \"{0}\" \"color sigma_a\" {1} \"color sigma_s\" {2} \"color Le\" {3} {4} "
      "\"point p0\" [-{5} -{5} {6}] \"point p1\" [{5} {5} {7}] {8}\n",
      kind, rgbText(k.sigma_a * scale), rgbText(k.sigma_s * scale), rgbText(k.Le * scale),
      m.phase.params, half, z0, z1, params);
}

}  // namespace

PhaseCase henyeyGreensteinCase(double g) {
  return {"g" + fmt::format("{}", g), fmt::format("\"float g\" {}", g), henyeyGreensteinOf(g)};
}

std::vector<PhaseCase> phaseCases() {
  // PBRT-v2's Schlick: k = 1.5 g - 0.5 g^3.
  const double k = 1.5 * 0.6 - 0.5 * 0.6 * 0.6 * 0.6;
  return {
      {"isotropic", "\"string phase\" \"isotropic\"", [](double) { return 1.0; }},
      {"rayleigh", "\"string phase\" \"rayleigh\"", rayleigh()},
      {"hg", "\"string phase\" \"henyeygreenstein\" \"float g\" .7", henyeyGreensteinOf(0.7)},
      {"hgbackward", "\"string phase\" \"henyeygreenstein\" \"float g\" -.6",
       henyeyGreensteinOf(-0.6)},
      {"schlick", "\"string phase\" \"schlick\" \"float g\" .6", schlick(k)},
      {"schlickbackward", "\"string phase\" \"schlick\" \"float g\" -.6", schlick(-k)},
      {"miehazy", "\"string phase\" \"miehazy\"", mie(8)},
      {"miemurky", "\"string phase\" \"miemurky\"", mie(32)},
      {"mixture",
       "\"string phase\" [\"henyeygreenstein\" \"henyeygreenstein\"] \"float g\" [.8 -.3] "
       "\"float phaseweights\" [3 1]",
       mixed(0.75, henyeyGreensteinOf(0.8), henyeyGreensteinOf(-0.3))},
      {"rayleighwithmie",
       "\"string phase\" [\"rayleigh\" \"miemurky\"] \"float phaseweights\" [.4 .6]",
       mixed(0.4, rayleigh(), mie(32))},
  };
}

const char* nameOf(Build build) {
  switch (build) {
    case Build::Homogeneous:
      return "homogeneous";
    case Build::Exponential:
      return "exponential";
    case Build::Grid:
      return "grid";
    case Build::Split:
      return "split";
    case Build::Overlap:
      return "overlap";
  }
  return "";
}

std::string volumesOf(const SlabMedium& m, double half) {
  switch (m.build) {
    case Build::Homogeneous:
      return volume("homogeneous", m, half, 0, 1, 1);
    case Build::Exponential: {
      // Int_0^1 a exp(-b z) dz = 1.
      constexpr double b = 2;
      return volume("exponential", m, half, 0, 1, 1,
                    fmt::format("\"float a\" {} \"float b\" {} \"vector updir\" [0 0 1]",
                                b / -std::expm1(-b), b));
    }
    case Build::Grid:
      // Between voxel centres the density is linear, beyond the outer ones constant: the integral
      // over the slab is the mean of the voxels, 1.
      return volume("volumegrid", m, half, 0, 1, 1,
                    "\"integer nx\" 1 \"integer ny\" 1 \"integer nz\" 8 "
                    "\"float density\" [.5 2 .25 0 0 1.25 3 1]");
    case Build::Split:
      return volume("homogeneous", m, half, 0, 0.3, 1) + volume("homogeneous", m, half, 0.3, 1, 1);
    case Build::Overlap:
      return volume("homogeneous", m, half, 0, 1, 1.0 / 3) +
             volume("homogeneous", m, half, 0, 1, 2.0 / 3);
  }
  return "";
}

std::string slabView(double mu, bool onLitSide) {
  // The dark side is seen from between the slab and the floor, half a thousandth under the slab.
  const double s = std::sqrt(1 - mu * mu);
  return onLitSide ? fmt::format("{} 0 {}  0 0 1  0 1 0", 2 * s, 1 + 2 * mu)
                   : fmt::format("{} 0 {}  0 0 0  0 1 0", 5e-4 * s, -5e-4 * mu);
}

SuiteScene slabScene(const Method& method, const std::string& volumes, const std::string& light,
                     double mu, bool onLitSide) {
  return {slabView(mu, onLitSide), light + volumes + floorAt(-.001, 2 * method.slabExtent, 0)};
}

std::vector<SlabColours> solve(const SlabMedium& medium, const std::vector<double>& mus) {
  std::vector<SlabColours> result(mus.size());
  const AveragedPhase phase = averaged(medium.phase.phase);
  for (std::size_t c = 0; c < 3; ++c) {
    const bool isAsBefore =
        c > 0 && medium.tau[c] == medium.tau[c - 1] && medium.albedo[c] == medium.albedo[c - 1];
    const auto slab = isAsBefore ? std::vector<SlabRadiance>()
                                 : solveSlab(medium.albedo[c], medium.tau[c], phase, mus);
    for (std::size_t i = 0; i < mus.size(); ++i) {
      result[i].R[c] = isAsBefore ? result[i].R[c - 1] : slab[i].R;
      result[i].T[c] = isAsBefore ? result[i].T[c - 1] : slab[i].T;
    }
  }
  return result;
}

}  // namespace brume::test
