// SPDX-License-Identifier: Apache-2.0
// Lights where they meet a surface or a boundary, lights without size, lights seen edge-on, point
// lights inside a medium.
#include <cmath>

#include "stability/stability_case.h"
#include "support/adding_doubling.h"
#include "support/boxes.h"
#include "support/render_text.h"

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
/// A matte plane at the height y, out to 9 on each side.
std::string ceiling(double y) {
  return fmt::format(
      "AttributeBegin\nMaterial \"matte\" \"color Kd\" [.5 .5 .5]\nShape \"trianglemesh\" "
      "\"integer indices\" [0 1 2 0 2 3] \"point P\" [-9 {0} -9  9 {0} -9  9 {0} 9  -9 {0} "
      "9]\nAttributeEnd\n",
      y);
}
std::string ball(double radius) {
  return fmt::format(
      "AttributeBegin\nAreaLightSource \"area\" \"color L\" {}\nTranslate -.5 1.5 .125\nShape "
      "\"sphere\" \"float radius\" {}\nAttributeEnd\n",
      rgbText(3 / (3.14159265358979 * radius * radius)), radius);
}

/// Light scattered once by the medium around a point light, along a ray that passes it at the
/// distance D from -2 to 2, all pixels the same ray. It grows like 1 / D: with dt = D dtheta /
/// cos^2 theta and the distance D / cos theta from the light,
///   L = I sigma_s / D Int f_p(sin theta) exp(-sigma_t (2 + D tan theta + D / cos theta)) dtheta
StabilityCase pastALight(double D) {
  return {"lights",
          fmt::format("point light inside, one scattering along a ray {:g} beside it", D),
          1e-4,
          "float distances along the ray near the light",
          0.01,
          [=](Form form) {
            constexpr int kSteps = 200000;
            constexpr double kEnd = 2, kPi = 3.14159265358979323846;
            const std::array<double, 3> sigma_s = {2, 1.5, 1}, sigma_a = {.1, .2, .3};
            const double first = std::atan(-kEnd / D), step = -2 * first / kSteps;
            std::array<double, 3> expected{};
            for (int i = 0; i < kSteps; ++i) {
              const double theta = first + (i + 0.5) * step;
              // The ray goes on in its direction or turns: the cosine of the angle is -sin theta.
              const double phase = henyeyGreensteinOf(0.4)(-std::sin(theta)) / (4 * kPi);
              const double length = kEnd + D * std::tan(theta) + D / std::cos(theta);
              for (std::size_t c = 0; c < 3; ++c)
                expected[c] += 3 * sigma_s[c] / D * phase *
                               std::exp(-(sigma_s[c] + sigma_a[c]) * length) * step;
            }
            const std::string world = fmt::format(
                "Volume \"homogeneous\" \"color sigma_s\" {} \"color sigma_a\" {} \"float g\" .4 "
                "\"point p0\" [-2 -2 -2] \"point p1\" [2 2 2]\n{}",
                rgbText(sigma_s), rgbText(sigma_a), pointLight(D, 0, 0));
            return compareExact(
                sceneText({"volpath", "GlobalIntegrator \"volpath\" \"integer maxdepth\" 1"},
                          {"0 0 4  0 0 0  0 1 0", world, 1e-12}, kCasePixels, caseSamples(form)),
                expected);
          }};
}

/// Two scatterings near a light inside, seen along one ray: the noise of a single sample is finite.
/// It is 1.9 of the mean; 4.5 among as many samples, and growing with them, when segments do not
/// look at lights and the tail of 1 / distance^2 is met by chance.
StabilityCase varianceAroundALight() {
  return {
      "lights",
      "point light inside, noise of a single sample (not a difference)",
      2.6,
      "a finite variance",
      0,
      [=](Form form) {
        const int samples = 32 * caseSamples(form);
        const std::string medium =
            "Volume \"homogeneous\" \"color sigma_s\" [1.5 1.5 1.5] \"color sigma_a\" [.2 .2 .2] "
            "\"float g\" .4 \"point p0\" [-2 -1 -2] \"point p1\" [2 1 2]\n";
        const SuiteScene scene = {".6 .7 .9  .48 .2 0  0 1 0", pointLight(.5, .25, -.125) + medium,
                                  1e-6};
        const RenderResult r =
            renderText(sceneText({"volpath", "GlobalIntegrator \"volpath\" \"integer maxdepth\" 2"},
                                 scene, kCasePixels, samples));
        const Estimate e = estimateOf(r.image, "G");
        return StabilityResult{e.standardError / e.mean * std::sqrt(samples) * kCasePixels, 0,
                               faultsOf(r.stats)};
      }};
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
  // A panel in a ceiling, a millionth below it, and above, where the ceiling hides it.
  cases.push_back(pair("panel in a matte ceiling, 1e-6 below it", 1e-4, move,
                       ceiling(.75) + panel(.75, .5, 4) + kMedium,
                       ceiling(.75) + panel(.75 - 1e-6, .5, 4) + kMedium));
  for (const double D : {1e-2, 1e-4, 1e-6}) cases.push_back(pastALight(D));
  cases.push_back(varianceAroundALight());
  return cases;
}

}  // namespace brume::test
