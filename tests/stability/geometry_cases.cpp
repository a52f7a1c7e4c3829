// SPDX-License-Identifier: Apache-2.0
// Geometry that meets exactly: faces on a medium's boundary, rays along cells, cameras on a
// boundary, triangles thin as needles.
#include <cmath>

#include "stability/stability_case.h"
#include "support/boxes.h"
#include "support/slab_cases.h"

namespace brume::test {

namespace {

const std::string kMedium =
    "\"color sigma_s\" [2 1.5 1] \"color sigma_a\" [.1 .2 .3] \"float g\" .4";
const std::string kLights =
    "LightSource \"infinite\" \"color L\" [.3 .3 .3]\n"
    "LightSource \"point\" \"point from\" [2 3 2] \"color I\" [9 9 9]\n";

std::string volpathScene(const SuiteScene& scene, int samples) {
  return sceneText(judgedMethods().front(), scene, kCasePixels, samples);
}

/// A square floor from -4 to 4 in the plane y, as one quadrilateral.
std::string quad(double y) {
  return fmt::format(
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [-4 {0} -4  4 {0} -4  "
      "4 "
      "{0} 4  -4 {0} 4]\n",
      y);
}

/// The same in strips whose width falls from 1/2 to 2^-20: needles up to 8 million times as long as
/// wide.
std::string needles(double y) {
  std::string points, indices;
  std::vector<double> xs = {-4};
  double width = 0.5;
  while (xs.back() < 4 && xs.size() < 2000) {
    xs.push_back(std::min(4.0, xs.back() + width));
    width = xs.back() < 0 ? std::max(width * 0.5, 0x1p-20) : 0.5;
    if (xs.size() > 40) width = 0.25;
  }
  for (std::size_t i = 0; i < xs.size(); ++i) {
    points += fmt::format(" {0:.9g} {1} -4 {0:.9g} {1} 4", xs[i], y);
    if (i > 0)
      indices += fmt::format(" {0} {1} {2} {0} {2} {3}", 2 * i - 2, 2 * i, 2 * i + 1, 2 * i - 1);
  }
  return fmt::format("Shape \"trianglemesh\" \"integer indices\" [{}] \"point P\" [{}]\n", indices,
                     points);
}

std::string onFloor(const std::string& floor) {
  return kLights + unevenGrid(kMedium) +
         "AttributeBegin\nMaterial \"matte\" \"color Kd\" [.5 .5 .5]\n" + floor + "AttributeEnd\n";
}

/// Two scenes seen from the same place.
StabilityCase pair(const std::string& group, const std::string& name, double tolerance,
                   const std::string& reason, const SuiteScene& a, const SuiteScene& b) {
  return {group, name, tolerance, reason, 0.01, [=](Form form) {
            const int samples = caseSamples(form);
            return comparePaired(volpathScene(a, samples), volpathScene(b, samples));
          }};
}

const std::string kView = "3 2 4  0 0 0  0 1 0";

std::vector<StabilityCase> surfaceCases() {
  const std::string rounding = "a few paths are turned aside";
  std::vector<StabilityCase> cases;
  cases.push_back(pair("needle triangles", "floor of strips down to 2^-20 wide", 1e-4, rounding,
                       {kView, onFloor(quad(-1.125)), 40}, {kView, onFloor(needles(-1.125)), 40}));
  for (const double move : {-1e-6, 1e-6})
    cases.push_back(pair("coplanar faces",
                         fmt::format("floor on the boundary, moved by {:g}", move), 1e-4,
                         "the move itself, and " + rounding, {kView, onFloor(quad(-1)), 40},
                         {kView, onFloor(quad(-1 + move)), 40}));
  // All six faces of the box are walls as well.
  cases.push_back(
      {"coplanar faces", "closed white box around its medium, furnace", 1e-5, "sums of floats",
       0.02, [](Form form) {
         return compareExact(
             volpathScene({kFromInside, emittingBox() + unevenGrid("\"color sigma_s\" [1 2 4]")},
                          4 * caseSamples(form)),
             gray3(1));
       }});
  return cases;
}

/// A ray through the uneven grid between two points, all pixels the same ray, in absorption alone.
StabilityCase alongRay(const std::string& name, const std::array<double, 3>& from,
                       const std::array<double, 3>& to) {
  return {
      "rays along cells", name, 1e-5, "float optical depth", 1e-6, [=](Form form) {
        constexpr int kSteps = 200000;
        double density = 0, length = 0;
        std::array<double, 3> d;
        for (std::size_t a = 0; a < 3; ++a) {
          d[a] = to[a] - from[a];
          length += d[a] * d[a];
        }
        length = std::sqrt(length);
        for (int i = 0; i < kSteps; ++i) {
          const double s = (i + 0.5) / kSteps;
          density += unevenDensity(from[0] + s * d[0], from[1] + s * d[1], from[2] + s * d[2]) *
                     length / kSteps;
        }
        const std::array<double, 3> sigma = {.1, .5, 2};
        std::array<double, 3> expected;
        for (std::size_t c = 0; c < 3; ++c) expected[c] = std::exp(-sigma[c] * density);
        // The camera stands one length before the grid and looks along the ray exactly.
        const std::string lookAt = fmt::format("{} {} {}  {} {} {}  .1 1 .2", from[0] - d[0],
                                               from[1] - d[1], from[2] - d[2], to[0], to[1], to[2]);
        return compareExact(
            volpathScene({lookAt, sky() + unevenGrid("\"color sigma_a\" " + rgbText(sigma)), 1e-12},
                         caseSamples(form)),
            expected);
      }};
}

std::vector<StabilityCase> cellCases() {
  // Voxel centres, which are the cells' corners, lie at x, z = 0, +-2/3 and y = +-1/4, +-3/4.
  std::vector<StabilityCase> cases;
  cases.push_back(alongRay("in a cell's face", {0, .1, 1}, {0, .1, -1}));
  cases.push_back(alongRay("along a cell's edge", {0, .25, 1}, {0, .25, -1}));
  cases.push_back(alongRay("along an edge, the other way", {0, .25, -1}, {0, .25, 1}));
  cases.push_back(alongRay("in a face, along y", {0, 1, .2}, {0, -1, .2}));
  cases.push_back(alongRay("across faces at right angles", {1, .1, .2}, {-1, .1, .2}));
  cases.push_back(alongRay("diagonal in the plane x = y", {1, 1, .5}, {-1, -1, .5}));
  cases.push_back(alongRay("through the box's corners", {1, 1, 1}, {-1, -1, -1}));
  cases.push_back(alongRay("from corner to corner upwards", {-1, -1, 1}, {1, 1, -1}));
  cases.push_back(alongRay("through corners of a cell", {1, .75, 1}, {-1, .75, -1}));
  // Scattering as well: paths that begin on an edge against a hair beside it.
  for (const double aside : {-1e-6, 1e-6})
    cases.push_back(
        pair("rays along cells", fmt::format("scattering, {:g} aside of an edge", aside), 1e-4,
             "the move itself", {"0 .25 4  0 .25 0  0 1 0", kLights + unevenGrid(kMedium), 1e-12},
             {fmt::format("{0} {1} 4  {0} {1} 0  0 1 0", aside, .25 + aside),
              kLights + unevenGrid(kMedium), 1e-12}));
  return cases;
}

std::vector<StabilityCase> cameraCases() {
  std::vector<StabilityCase> cases;
  struct Place {
    const char *name, *eye, *target;
    std::array<double, 3> inward;
  };
  const Place places[] = {
      {"on a face, looking in", "{} {} {}", "-.3 .1 0", {-1, 0, 0}},
      {"on an edge, looking in", "{} {} {}", "-.3 .1 0", {-1, -1, 0}},
      {"on a corner, looking in", "{} {} {}", "-.3 .1 0", {-1, -1, -1}},
      {"on a face, looking out", "{} {} {}", "5 2 1", {-1, 0, 0}},
  };
  for (const Place& place : places)
    for (const double move : {-1e-6, 1e-6}) {
      std::array<double, 3> at, moved;
      for (std::size_t a = 0; a < 3; ++a) {
        at[a] = place.inward[a] != 0 ? -place.inward[a] : 0.125;
        moved[a] = at[a] + move * place.inward[a];
      }
      const auto view = [&](const std::array<double, 3>& p) {
        return fmt::format("{:.9g} {:.9g} {:.9g}  {}  0 0 1", p[0], p[1], p[2], place.target);
      };
      const std::string world =
          kLights + fmt::format("Volume \"homogeneous\" {} {}\n", kMedium, kUnitBox);
      cases.push_back(pair("camera on a boundary",
                           fmt::format("{}, moved by {:g}", place.name, move), 1e-4,
                           "the move itself", {view(at), world, 60}, {view(moved), world, 60}));
    }
  return cases;
}

}  // namespace

std::vector<StabilityCase> geometryCases() {
  std::vector<StabilityCase> cases = surfaceCases();
  for (const auto& more : {cellCases(), cameraCases()})
    cases.insert(cases.end(), more.begin(), more.end());
  return cases;
}

}  // namespace brume::test
