// SPDX-License-Identifier: Apache-2.0
// A scene with everything in it, made larger, moved away, made brighter.
#include <fmt/format.h>

#include "stability/stability_case.h"

namespace brume::test {

namespace {

/// How the scene is written: all lengths times `scale`, all radiances times `brightness`, and
/// moved: by a transform around all, or by an offset added to the numbers themselves.
struct Variant {
  double scale = 1, brightness = 1;
  std::array<double, 3> translation{};
  std::array<double, 3> offset{};
};

/// Smoke over a floor, a glass ball, an emitting and absorbing box that overlaps the smoke; lights
/// of all kinds, one of them in the smoke. Coordinates are multiples of 1/8, so that the offsets
/// round nothing.
std::string everything(const Variant& v, int samples) {
  const double s = v.scale, k = v.brightness;
  const auto point = [&](double x, double y, double z) {
    return fmt::format("{:.17g} {:.17g} {:.17g}", x * s + v.offset[0], y * s + v.offset[1],
                       z * s + v.offset[2]);
  };
  const auto move =
      fmt::format("Translate {} {} {}", v.translation[0], v.translation[1], v.translation[2]);
  const auto back =
      fmt::format("Translate {} {} {}", -v.translation[0], -v.translation[1], -v.translation[2]);
  const auto length = [&](double l) { return fmt::format("{:.17g}", l * s); };
  std::string text = fmt::format(
      "LookAt {}  {}  0 1 0\n{}\nCamera \"perspective\" \"float fov\" 40\n"
      "Film \"image\" \"integer xresolution\" {} \"integer yresolution\" {}\nPixelFilter \"box\"\n"
      "Sampler \"random\" \"integer pixelsamples\" {}\nGlobalIntegrator \"volpath\"\n"
      "WorldBegin\n{}\n",
      point(1, 2, 5), point(0, .5, 0), back, kCasePixels, kCasePixels, samples, move);
  text += fmt::format("LightSource \"infinite\" \"color L\" {}\n", rgbText(0.2 * k));
  text += fmt::format("LightSource \"point\" \"point from\" [{}] \"color I\" {}\n",
                      point(.25, 1.25, .125), rgbText(2 * k * s * s));
  text += fmt::format(
      "LightSource \"spot\" \"point from\" [{}] \"point to\" [{}] \"color I\" {} \"float "
      "coneangle\" "
      "30\n",
      point(-2, 3, 1), point(0, 0, 0), rgbText(20 * k * s * s));
  text +=
      fmt::format("LightSource \"distant\" \"point from\" [{}] \"point to\" [{}] \"color L\" {}\n",
                  point(1, 1, 1), point(0, 0, 0), rgbText(0.5 * k));
  text += fmt::format(
      "AttributeBegin\nAreaLightSource \"area\" \"color L\" {}\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [{} {} {} {}]\n"
      "AttributeEnd\n",
      rgbText(3 * k), point(-.5, 3, -.5), point(.5, 3, -.5), point(.5, 3, .5), point(-.5, 3, .5));
  text += fmt::format(
      "AttributeBegin\nMaterial \"matte\" \"color Kd\" [.5 .6 .7]\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [{} {} {} {}]\n"
      "AttributeEnd\n",
      point(-4, -.5, -4), point(4, -.5, -4), point(4, -.5, 4), point(-4, -.5, 4));
  text += fmt::format(
      "AttributeBegin\nMaterial \"glass\"\nTranslate {}\nShape \"sphere\" \"float radius\" {}\n"
      "AttributeEnd\n",
      point(1, 0, 1), length(.375));
  text += fmt::format(
      "Volume \"volumegrid\" \"color sigma_s\" [{:.9g} {:.9g} {:.9g}] \"color sigma_a\" "
      "[{:.9g} {:.9g} {:.9g}] \"float g\" .5 \"point p0\" [{}] \"point p1\" [{}]\n"
      "  \"integer nx\" 2 \"integer ny\" 3 \"integer nz\" 2 \"float density\" [0 .5 1 2 .25 0 .75 "
      "1 "
      "0 1.5 .5 2]\n",
      2 / s, 1.5 / s, 1 / s, .1 / s, .2 / s, .3 / s, point(-1, 0, -1), point(1, 2, 1));
  text += fmt::format(
      "Volume \"homogeneous\" \"color sigma_s\" [{0:.9g} {0:.9g} {0:.9g}] \"color sigma_a\" "
      "[{1:.9g} {1:.9g} {1:.9g}] \"color Le\" [{2:.9g} {3:.9g} {4:.9g}] \"float g\" -.25\n"
      "  \"point p0\" [{5}] \"point p1\" [{6}]\nWorldEnd\n",
      .5 / s, .25 / s, .5 * k / s, .25 * k / s, .125 * k / s, point(-2, -.5, -2), point(.5, 1, .5));
  return text;
}

StabilityCase everythingCase(const std::string& group, const std::string& name, const Variant& v,
                             double tolerance, const std::string& reason) {
  return {group, name, tolerance, reason, 0.01, [v](Form form) {
            const int samples = caseSamples(form);
            return comparePaired(everything({}, samples), everything(v, samples), v.brightness);
          }};
}

}  // namespace

std::vector<StabilityCase> scaleCases() {
  std::vector<StabilityCase> cases;
  const std::string rounding = "rounding of the scene's numbers to float turns a few paths aside";
  for (const double s : {1e-6, 1e-4, 1e-2, 1e2, 1e4, 1e6})
    cases.push_back(everythingCase("scale", fmt::format("{:g}", s), {.scale = s}, 1e-5, rounding));
  cases.push_back(everythingCase("translation", "1e5 along x by a transform",
                                 {.translation = {1e5, 0, 0}}, 1e-5, rounding));
  cases.push_back(everythingCase("translation", "1e5 along all axes by a transform",
                                 {.translation = {1e5, -1e5, 1e5}}, 1e-5, rounding));
  cases.push_back(everythingCase("translation", "1e5 along x in the numbers",
                                 {.offset = {1e5, 0, 0}}, 1e-5, rounding));
  cases.push_back(everythingCase("translation", "1e5 along all axes in the numbers",
                                 {.offset = {1e5, -1e5, 1e5}}, 1e-5, rounding));
  for (const double k : {1e-20, 1e-10, 1e10, 1e20})
    cases.push_back(everythingCase("radiance", fmt::format("{:g}", k), {.brightness = k}, 1e-5,
                                   "rounding of the lights' numbers to float"));
  return cases;
}

}  // namespace brume::test
