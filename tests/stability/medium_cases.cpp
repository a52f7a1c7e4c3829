// SPDX-License-Identifier: Apache-2.0
// Media at the ends of their ranges: optical depth, anisotropy, albedo, densities.
#include <cmath>

#include "stability/stability_case.h"
#include "support/boxes.h"
#include "support/slab_cases.h"

namespace brume::test {

namespace {

constexpr double kFourPi = 12.5663706143591729539;

std::string volpathScene(const SuiteScene& scene, int samples, const std::string& params = "") {
  return sceneText({"volpath", "GlobalIntegrator \"volpath\" " + params}, scene, kCasePixels,
                   samples);
}

StabilityCase furnace(const std::string& group, const std::string& name, const std::string& medium,
                      const std::string& lookAt = kFromOutside) {
  return {
      group, name, 1e-5, "sums of floats", 0.02, [=](Form form) {
        return compareExact(volpathScene({lookAt, sky() + medium}, caseSamples(form)), gray3(1));
      }};
}

/// Absorbs, emits as much, and scatters: shows 1 under a sky of 1.
std::string balanced(double sigma_a, double sigma_s, double g = 0) {
  return fmt::format("\"color sigma_a\" {0} \"color Le\" {0} \"color sigma_s\" {1} \"float g\" {2}",
                     rgbText(sigma_a), rgbText(sigma_s), g);
}
std::string homogeneous(const std::string& coefficients) {
  return fmt::format("Volume \"homogeneous\" {} {}\n", coefficients, kUnitBox);
}

/// One scattering of a distant light in a slab, seen along the normal, at a small angle between
/// light and view: where the phase function of g near 1 peaks.
StabilityCase onceThrough(double g, double angle, bool lit) {
  const std::string name =
      fmt::format("{} {} rad from the axis, {}", g, angle, lit ? "reflected" : "transmitted");
  return {
      "g, one scattering",
      name,
      1e-3,
      "float directions are rounded by 6e-8: 1e-4 of the peak's width of 1e-3",
      0.01,
      [=](Form form) {
        const double tau = 0.5, mu0 = std::cos(angle);
        const SlabMedium medium{gray3(tau), gray3(1), henyeyGreensteinCase(g)};
        const std::string light =
            fmt::format("LightSource \"distant\" \"point from\" [{} 0 {}] \"point to\" [0 0 0]\n",
                        std::sin(angle), mu0);
        // The light travels down; the viewer looks down on the lit side, up on the other.
        const double cosine = lit ? -mu0 : mu0, k = 1 + 1 / mu0, d = 1 / mu0 - 1;
        const double path = lit ? -std::expm1(-tau * k) / k
                                : std::exp(-tau) * (d == 0 ? tau : -std::expm1(-tau * d) / d);
        const double expected = henyeyGreensteinOf(g)(cosine) / kFourPi * path;
        const Method method = judgedMethods().front();
        return compareExact(volpathScene(slabScene(method, volumesOf(medium, 1e4), light, 1, lit),
                                         8 * caseSamples(form), "\"integer maxdepth\" 1"),
                            gray3(expected));
      }};
}

/// Light scattered once by an ever thinner box, over its density.
StabilityCase thin(double density) {
  const auto scene = [](double sigma, int samples) {
    const std::string light = "LightSource \"point\" \"point from\" [.3 .2 .4]\n";
    return volpathScene({kFromOutside, light + homogeneous(balanced(0, sigma, .5)), 5}, samples);
  };
  return {"optical depth",
          fmt::format("{:g}", density),
          5 * std::max(density, 1e-4),
          "second scatterings and attenuation, of the order of the depth along the ray",
          0.01,
          [=](Form form) {
            const int samples = caseSamples(form);
            return comparePaired(scene(1e-4, samples), scene(density, samples), density / 1e-4);
          }};
}

/// The reflected light of a slab that lets nothing through does not depend on its depth.
StabilityCase thick(double tau) {
  return {"optical depth", fmt::format("{:g}", tau), 1e-5, "sums of floats", 0.01, [=](Form form) {
            const SlabMedium shown{gray3(tau), gray3(0.8), henyeyGreensteinCase(0.3)};
            SlabMedium solved = shown;
            solved.tau = gray3(40);  // exp(-40) is left
            const double R = solve(solved, {0.5})[0].R[0];
            const Method method = judgedMethods().front();
            return compareExact(
                volpathScene(slabScene(method, volumesOf(shown, 1e4), sky(), 0.5, true),
                             4 * caseSamples(form)),
                gray3(R));
          }};
}

std::string grid(const std::string& coefficients, const std::vector<std::string>& densities) {
  std::string text = "Volume \"volumegrid\" " + coefficients + " " + kUnitBox +
                     " \"integer nx\" 2 \"integer ny\" 2 \"integer nz\" 2 \"float density\" [";
  for (const std::string& d : densities) text += d + " ";
  return text + "]\n";
}

/// A grid that is as good as empty before sky and floor: what is seen without it.
StabilityCase asIfEmpty(const std::string& name, const std::string& density) {
  return {"grid", name, 0, "bit-identical", 0, [=](Form form) {
            // The floor is black: whatever random numbers a ray takes on its way, it sees the same.
            const std::string world = sky() + floorAt(-1.5, 10, 0);
            const std::string medium = grid(balanced(0, 1), std::vector<std::string>(8, density));
            const int samples = caseSamples(form);
            return comparePaired(volpathScene({kFromOutside, world, 60}, samples),
                                 volpathScene({kFromOutside, world + medium, 60}, samples));
          }};
}

StabilityCase timesTen10(double factor) {
  return {"grid",
          fmt::format("densities times {:g}, coefficients divided by it", factor),
          1e-5,
          "rounding of the products",
          0.01,
          [=](Form form) {
            const std::string light = "LightSource \"point\" \"point from\" [2 2 2]\n";
            const auto scene = [&](double f) {
              return volpathScene(
                  {kFromOutside,
                   light + unevenGrid(fmt::format("\"color sigma_s\" {} \"color sigma_a\" {}",
                                                  rgbText(2 / f), rgbText(.3 / f)),
                                      f),
                   30},
                  caseSamples(form));
            };
            return comparePaired(scene(1), scene(factor), 1);
          }};
}

}  // namespace

std::vector<StabilityCase> mediumCases() {
  std::vector<StabilityCase> cases;
  for (const double tau : {1e-6, 1e-5, 1e-3}) cases.push_back(thin(tau));
  for (const double tau : {1e2, 1e3, 1e4}) cases.push_back(thick(tau));
  for (const double tau : {1e-6, 1e-3, 1.0, 1e2, 1e4})
    cases.push_back(furnace("optical depth", fmt::format("{:g}, furnace", tau),
                            homogeneous(balanced(.3 * tau, .7 * tau))));

  for (const double g : {-0.999, -0.99, -0.5, 0.0, 0.5, 0.99, 0.999}) {
    cases.push_back(furnace("g", fmt::format("{}, furnace", g), homogeneous(balanced(.2, 3, g))));
    for (const double angle : {0.002, 0.2})
      for (const bool lit : {true, false}) cases.push_back(onceThrough(g, angle, lit));
  }

  cases.push_back(furnace("albedo", "0", homogeneous(balanced(3, 0))));
  cases.push_back(furnace("albedo", "1 - 1e-7", homogeneous(balanced(3e-7, 3))));
  cases.push_back(furnace("albedo", "1", homogeneous(balanced(0, 3))));
  cases.push_back(
      furnace("albedo", "1, depth 30, from inside", homogeneous(balanced(0, 15)), kFromInside));

  cases.push_back(asIfEmpty("all densities 0", "0"));
  cases.push_back(asIfEmpty("all densities denormal", "1e-40"));
  cases.push_back(timesTen10(1e10));
  cases.push_back(timesTen10(1e-10));
  cases.push_back(furnace(
      "grid", "0, denormal and 1e10 in one, furnace",
      grid(balanced(.3, .7, .4), {"0", "1e-40", "1e10", "1", "1e-40", "1e10", "0", "1e-3"})));
  // From one float to the next along the ray there are thousands of optical depths.
  cases.push_back(furnace("grid", "1e10 everywhere, furnace",
                          grid(balanced(.3, .7, .4), std::vector<std::string>(8, "1e10"))));
  cases.push_back(furnace("grid", "1e10 everywhere, chromatic, furnace",
                          grid("\"color sigma_s\" [.1 1 10] \"color sigma_a\" [.1 1 10] "
                               "\"color Le\" [.1 1 10]",
                               std::vector<std::string>(8, "1e10"))));
  cases.push_back(furnace("grid", "one voxel of 1e10, furnace from inside",
                          grid(balanced(.3, .7, .4), {"1", "0", "1", "1", "1e10", "0", "1", "1"}),
                          kFromInside));
  return cases;
}

}  // namespace brume::test
