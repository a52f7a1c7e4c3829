// SPDX-License-Identifier: Apache-2.0
// Lights where they meet a surface or a boundary, lights without size, lights seen edge-on.
#include <cmath>

#include "stability/stability_case.h"
#include "support/boxes.h"

namespace brume::test {

namespace {

const std::string kMedium =
    "Volume \"homogeneous\" \"color sigma_s\" [2 1.5 1] \"color sigma_a\" [.1 .2 .3] \"float g\" "
    ".4 "
    "\"point p0\" [-2 -1 -2] \"point p1\" [2 1 2]\n";
const std::string kView = "3 .5 4  0 0 0  0 1 0";

/// Looks down past the lights, which it must not see: a point cannot be seen, a ball can.
const std::string kDownwards = "3 .5 4  1 -1 0  0 1 0";

std::string volpathScene(const std::string& world, int samples, const std::string& view) {
  return sceneText(judgedMethods().front(), {view, world, view == kView ? 40.0 : 15.0}, kCasePixels,
                   samples);
}

StabilityCase pair(const std::string& name, double tolerance, const std::string& reason,
                   const std::string& a, const std::string& b, const std::string& view = kView) {
  return {"lights", name, tolerance, reason, 0.02, [=](Form form) {
            // Balls are found by luck where points are by design: they need more samples.
            const int samples = (view == kDownwards ? 16 : 2) * caseSamples(form);
            return comparePaired(volpathScene(a, samples, view), volpathScene(b, samples, view));
          }};
}

std::string pointLight(double x, double y, double z) {
  return fmt::format(
      "LightSource \"point\" \"point from\" [{:.9g} {:.9g} {:.9g}] \"color I\" [3 3 "
      "3]\n",
      x, y, z);
}
/// A square from -half to half in the plane y that shines downwards.
std::string panel(double y, double half, double L) {
  return fmt::format(
      "AttributeBegin\nAreaLightSource \"area\" \"color L\" {2}\nMaterial \"matte\" \"color Kd\" "
      "[0 "
      "0 0]\nShape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [-{1} {0} -{1}  "
      "{1} {0} -{1}  {1} {0} {1}  -{1} {0} {1}]\nAttributeEnd\n",
      y, half, rgbText(L));
}
std::string blackPlane(double y) {
  return fmt::format(
      "AttributeBegin\nMaterial \"matte\" \"color Kd\" [0 0 0]\nShape \"trianglemesh\" \"integer "
      "indices\" [0 1 2 0 2 3] \"point P\" [-9 {0} -9  9 {0} -9  9 {0} 9  -9 {0} "
      "9]\nAttributeEnd\n",
      y);
}
std::string ball(double radius) {
  return fmt::format(
      "AttributeBegin\nAreaLightSource \"area\" \"color L\" {}\nTranslate -.5 1.5 .125\nShape "
      "\"sphere\" \"float radius\" {}\nAttributeEnd\n",
      rgbText(3 / (3.14159265358979 * radius * radius)), radius);
}

}  // namespace

std::vector<StabilityCase> lightCases() {
  std::vector<StabilityCase> cases;
  const std::string move = "the move itself";
  // On the floor: the light shines into the half-space above it.
  cases.push_back(pair("point light on a black floor, 1e-6 above it", 1e-3, move,
                       pointLight(0, -.5, 0) + kMedium + blackPlane(-.5),
                       pointLight(0, -.5 + 1e-6, 0) + kMedium + blackPlane(-.5)));
  for (const double d : {-1e-6, 1e-6})
    cases.push_back(pair(fmt::format("point light on the boundary, moved by {:g}", d), 1e-4, move,
                         pointLight(0, 1, 0) + kMedium, pointLight(0, 1 + d, 0) + kMedium));
  for (const double d : {-1e-6, 1e-6})
    cases.push_back(pair(fmt::format("panel on the boundary, moved by {:g}", d), 1e-4, move,
                         panel(1, .5, 4) + kMedium, panel(1 + d, .5, 4) + kMedium));
  for (const double radius : {1e-2, 1e-4, 1e-6})
    cases.push_back(pair(fmt::format("ball of radius {:g} for a point", radius), 1e-3,
                         "the ball's size", pointLight(-.5, 1.5, .125) + kMedium,
                         ball(radius) + kMedium, kDownwards));
  // The camera lies in the panel's plane.
  cases.push_back(pair("panel seen edge-on, moved by 1e-6", 1e-4, move, panel(.5, .5, 4) + kMedium,
                       panel(.5 + 1e-6, .5, 4) + kMedium));
  return cases;
}

}  // namespace brume::test
