// SPDX-License-Identifier: Apache-2.0
// Boxes of media as scene text.
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

namespace brume::test {

/// From -1 to 1 on each axis.
inline const std::string kUnitBox = "\"point p0\" [-1 -1 -1] \"point p1\" [1 1 1]";
inline const std::string kFromOutside = "4 3 5  .1 .2 .3  0 1 0";
inline const std::string kFromInside = ".3 .2 .1  1 2 3  0 1 0";

struct NamedMedium {
  std::string name, text;
};

/// The ways to fill the unit box with density 1 everywhere.
inline std::vector<NamedMedium> equalMedia(const std::string& coefficients) {
  std::string ones;
  for (int i = 0; i < 27; ++i) ones += " 1";
  return {
      {"homogeneous", fmt::format("Volume \"homogeneous\" {} {}\n", coefficients, kUnitBox)},
      {"grid", fmt::format("Volume \"volumegrid\" {} {} \"integer nx\" 3 \"integer ny\" 3 "
                           "\"integer nz\" 3 \"float density\" [{}]\n",
                           coefficients, kUnitBox, ones)},
      {"exponential",
       fmt::format("Volume \"exponential\" {} {} \"float b\" 0\n", coefficients, kUnitBox)},
      {"split",
       fmt::format("Volume \"homogeneous\" {0} \"point p0\" [-1 -1 -1] \"point p1\" [.2 1 1]\n"
                   "Volume \"homogeneous\" {0} \"point p0\" [.2 -1 -1] \"point p1\" [1 1 1]\n",
                   coefficients)},
  };
}

/// Walls in the faces of the unit box, half white, that radiate 1/2 inwards: in it every ray
/// carries 1 / (2 (1 - 1/2)) = 1.
std::string emittingBox();

/// Densities that vary by voxel, some of them 0; x fastest.
inline const std::vector<double> kVoxels = {
    0.2, 1.5, 0, 0.7, 0.9,  0, 0,   2.1, 1.2,  0.4,  0.6, 0.1, 0,    0.8,  1.9,  0,    0.3, 1.1,
    0.5, 0,   0, 2.5, 0.05, 1, 1.4, 0,   0.75, 0.35, 0,   1.6, 0.45, 0.15, 0.95, 0.65, 0,   2.2};
/// A 3 x 4 x 3 grid of them in the unit box.
inline std::string unevenGrid(const std::string& coefficients, double scale = 1) {
  std::string values;
  for (const double v : kVoxels) values += fmt::format(" {}", v * scale);
  return fmt::format(
      "Volume \"volumegrid\" {} {} \"integer nx\" 3 \"integer ny\" 4 \"integer nz\" 3 "
      "\"float density\" [{}]\n",
      coefficients, kUnitBox, values);
}
/// Its density at a point of the box: trilinear between voxel centres, the nearest one beyond them.
double unevenDensity(double x, double y, double z);

}  // namespace brume::test
