// SPDX-License-Identifier: Apache-2.0
#include "support/photon_methods.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"
#include "support/estimate.h"
#include "support/render_text.h"

namespace brume::test {

namespace {

// Pixels share their photons, so the error of a mean comes from renders with different seeds.
// |z| < 5 against the scatter of some 8 means (Student's t) fails by chance once in 1000; the seeds
// are fixed.
constexpr double kMaxZ = 5;

std::string scene(const std::string& method, const std::string& camera, const std::string& world,
                  int samples) {
  return fmt::format(
      "{}\nFilm \"image\" \"integer xresolution\" [6] \"integer yresolution\" [6]\n"
      "PixelFilter \"box\"\nSampler \"random\" \"integer pixelsamples\" [{}]\n"
      "GlobalIntegrator {}\nWorldBegin\n{}\nWorldEnd\n",
      camera, samples, method, world);
}

/// Mean of the green channel, or of another one, over seeds.
Estimate meanOverSeeds(const std::string& text, int seeds, int channel = 1) {
  std::vector<double> means;
  for (int seed = 0; seed < seeds; ++seed) {
    RenderSettings settings;
    settings.seed = static_cast<std::uint64_t>(seed);
    const RenderResult result = renderText(text, settings);
    EXPECT_EQ(result.stats[Stat::NanRadiance] + result.stats[Stat::InfiniteRadiance] +
                  result.stats[Stat::NegativeRadiance],
              0u);
    means.push_back(double{meanOf(result.image)[channel]});
  }
  Estimate e;
  for (const double m : means) e.mean += m / seeds;
  for (const double m : means) e.standardError += sqr(m - e.mean);
  e.standardError = std::sqrt(e.standardError / (seeds * (seeds - 1)));
  return e;
}

/// Along -z from 5 above, a square of half-width w seen in parallel.
std::string fromAbove(double w) {
  return fmt::format(
      "LookAt 0 0 5  0 0 0  0 1 0\n"
      "Camera \"orthographic\" \"float screenwindow\" [{0} {1} {0} {1}]",
      -w, w);
}

const std::string kSlabBounds = "\"point p0\" [-3 -3 0] \"point p1\" [3 3 1]";

}  // namespace

void checkFurnace(const std::string& method) {
  // The photons' kernels stay away from the sides; the other faces are at right angles to the rays.
  for (const char* coefficients :
       {"\"color sigma_s\" [2 2 2]", "\"color sigma_s\" [.5 2 8] \"float g\" .8"})
    for (const char* direct : {"true", "false"}) {
      const std::string text =
          scene(fmt::format("\"{}\" \"integer photons\" 20000 \"bool directvolume\" \"{}\"", method,
                            direct),
                fromAbove(1.5),
                fmt::format("LightSource \"infinite\" \"color L\" [1 1 1]\n"
                            "Volume \"homogeneous\" {} {}\n",
                            coefficients, kSlabBounds),
                4);
      for (int channel : {0, 1, 2}) {
        const Estimate e = meanOverSeeds(text, 5, channel);
        EXPECT_LT(std::abs(e.z(1)), kMaxZ) << coefficients << ' ' << direct << ' ' << e.mean;
        EXPECT_LT(e.standardError, 0.08);
      }
    }
}

void checkAgainstVolpath(const std::string& method) {
  const std::string light =
      "LightSource \"point\" \"point from\" [.3 .4 3] \"color I\" [20 20 20]\n";
  std::string grid;
  for (int i = 0; i < 27; ++i) grid += fmt::format(" {}", 0.4 + 0.1 * (i * 7 % 11));
  const std::string homogeneous = fmt::format(
      "Volume \"homogeneous\" \"color sigma_a\" [.1 .2 .4] \"color sigma_s\" [2 1 .5] "
      "\"float g\" .6 {}\n",
      kSlabBounds);
  const std::string varying = fmt::format(
      "Volume \"volumegrid\" \"color sigma_a\" [.1 .1 .1] \"color sigma_s\" [2 2 2] {} "
      "\"integer nx\" 3 \"integer ny\" 3 \"integer nz\" 3 \"float density\" [{}]\n",
      kSlabBounds, grid);
  struct Case {
    std::string medium;
    const char* directVolume;
  };
  for (const Case& c :
       {Case{homogeneous, "false"}, {varying, "true"}, {homogeneous + varying, "false"}}) {
    const Estimate exact =
        meanOverSeeds(scene("\"volpath\"", fromAbove(1), light + c.medium, 64), 5);
    const std::string photons = fmt::format(
        "\"{}\" \"integer photons\" 20000 \"float radius\" .1 \"bool directvolume\" \"{}\"", method,
        c.directVolume);
    const Estimate e = meanOverSeeds(scene(photons, fromAbove(1), light + c.medium, 4), 5);
    // Bias: none across the faces, which are at right angles to the rays.
    const double bias = 0.01 * exact.mean;
    EXPECT_LT(std::abs(e.mean - exact.mean),
              bias + kMaxZ * std::hypot(e.standardError, exact.standardError))
        << c.medium << c.directVolume << ' ' << e.mean << " against " << exact.mean;
    EXPECT_LT(e.standardError, 0.03 * exact.mean);
    EXPECT_LT(exact.standardError, 0.03 * exact.mean);
  }
}

void checkSurfacesAgainstVolpath(const std::string& method) {
  // A lamp that volpath can find through glass, a floor, a mirror seen by the camera.
  const std::string world =
      "AttributeBegin\nAreaLightSource \"area\" \"color L\" [40 40 40]\n"
      "Translate .3 .3 1.6\nShape \"sphere\" \"float radius\" .25\nAttributeEnd\n"
      "Material \"matte\" \"color Kd\" [.7 .7 .7]\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] "
      "\"point P\" [-3 -3 0  3 -3 0  3 3 0  -3 3 0]\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] "
      "\"point P\" [-1.5 -3 0  -1.5 3 0  -1.5 3 3  -1.5 -3 3]\n"
      "AttributeBegin\nMaterial \"mirror\"\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] "
      "\"point P\" [1 -1 .3  1 1 .3  .4 1 .1  .4 -1 .1]\nAttributeEnd\n"
      "AttributeBegin\nMaterial \"glass\"\nTranslate -.3 -.3 .7\n"
      "Shape \"sphere\" \"float radius\" .4\nAttributeEnd\n"
      "Volume \"homogeneous\" \"color sigma_a\" [.05 .05 .05] \"color sigma_s\" [.3 .3 .3] "
      "\"point p0\" [-2 -2 -.1] \"point p1\" [2 2 2.5]\n";
  const std::string camera = fromAbove(0.9);
  const Estimate exact = meanOverSeeds(scene("\"volpath\"", camera, world, 128), 4);
  const std::string photons =
      fmt::format("\"{}\" \"integer photons\" 10000 \"integer surfacephotons\" 20000", method);
  const Estimate e = meanOverSeeds(scene(photons, camera, world, 32), 4);
  // Bias: radii of some 0.1 to 0.2 in a scene of size 2, blurred across the edges of shadows,
  // caustics and objects, where light is lost: 4 % of the whole light is seen here.
  EXPECT_LT(std::abs(e.mean - exact.mean),
            0.04 * exact.mean + kMaxZ * std::hypot(e.standardError, exact.standardError))
      << e.mean << " against " << exact.mean;
  EXPECT_LT(e.standardError, 0.04 * exact.mean);
  EXPECT_LT(exact.standardError, 0.04 * exact.mean);
}

void checkWall(const std::string& method) {
  // The wall at z = 0.5 hides the lamp and the light below; above is medium, but no light.
  const std::string world = fmt::format(
      "LightSource \"spot\" \"point from\" [0 0 -1] \"point to\" [0 0 0] \"float coneangle\" 20\n"
      "Volume \"homogeneous\" \"color sigma_s\" [1 1 1] {}\n"
      "Material \"matte\" \"color Kd\" [0 0 0]\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] "
      "\"point P\" [-9 -9 .5  9 -9 .5  9 9 .5  -9 9 .5]\n",
      "\"point p0\" [-3 -3 0] \"point p1\" [3 3 1]");
  for (const char* direct : {"true", "false"}) {
    const RenderResult result =
        renderText(scene(fmt::format("\"{}\" \"integer photons\" 5000 \"float radius\" .4 \"bool "
                                     "directvolume\" \"{}\"",
                                     method, direct),
                         fromAbove(0.5), world, 4));
    EXPECT_GT(result.stats[Stat::PhotonsStored], 1000u);
    EXPECT_EQ(meanOf(result.image), Rgb()) << direct;
  }
}

void checkThreads(const std::string& method) {
  const std::string text =
      scene(fmt::format("\"{}\" \"integer photons\" 5000 \"integer surfacephotons\" 5000", method),
            fromAbove(1),
            fmt::format("LightSource \"point\" \"point from\" [.3 .4 3] \"color I\" [20 20 20]\n"
                        "Volume \"homogeneous\" \"color sigma_s\" [2 1 .5] {}\n"
                        "Material \"matte\"\nShape \"sphere\" \"float radius\" .4\n"
                        "Shape \"disk\" \"float radius\" 3\n",
                        kSlabBounds),
            2);
  std::optional<std::vector<float>> first;
  for (int threads : {1, 2, 7}) {
    setThreadCount(threads);
    const auto image = renderText(text).image;
    if (!first) first = image.channels.at("G");
    EXPECT_EQ(image.channels.at("G"), *first) << threads << " threads";
  }
  setThreadCount(0);
}

void checkScarcity(const std::string& method) {
  const auto render = [&](const std::string& params, const std::string& world) {
    return meanOf(renderText(scene(fmt::format("\"{}\" \"integer photons\" 100 {}", method, params),
                                   fromAbove(1), world, 1))
                      .image);
  };
  const std::string medium =
      fmt::format("Volume \"homogeneous\" \"color sigma_s\" [1 1 1] {}\n", kSlabBounds);
  const std::string sky = "LightSource \"infinite\" \"color L\" [1 1 1]\n";
  // Nothing shines; nothing scatters; no medium.
  EXPECT_EQ(render("", medium), Rgb());
  EXPECT_EQ(render("", sky), Rgb(1));
  EXPECT_EQ(render("\"integer photons\" 0", sky + "Shape \"sphere\"").isFinite(), true);
  // Light that turns away from the medium, to a black ball: an error where photons are all there
  // is. (Light that leaves the scene at once is none to begin with: the plan leaves it out.)
  const std::string away =
      "LightSource \"spot\" \"point from\" [0 0 9] \"point to\" [0 0 10] \"float coneangle\" 20\n"
      "AttributeBegin\nMaterial \"matte\" \"color Kd\" [0 0 0]\nTranslate 0 0 12\n"
      "Shape \"sphere\"\nAttributeEnd\n";
  EXPECT_THROW(render("\"bool directvolume\" \"false\"", away + medium), SceneError);
  EXPECT_EQ(render("", away + medium), Rgb());
}

void checkMotion(const std::string& method) {
  const auto warnings = [&](const std::string& motion) {
    Log log(Log::Options{Verbosity::Normal, false, true});
    const std::string text =
        scene(fmt::format("\"{}\" \"integer photons\" 100 \"integer surfacephotons\" 100", method),
              fromAbove(1),
              "LightSource \"point\" \"point from\" [.3 .4 3] \"color I\" [20 20 20]\n"
              "Shape \"disk\" \"float radius\" 3\n" +
                  motion + "Shape \"sphere\" \"float radius\" .4\n",
              1);
    makeJob(text, {}, log)->run(std::atomic<bool>{false}, {});
    return log.warningCount();
  };
  EXPECT_EQ(warnings(""), 0);
  EXPECT_EQ(warnings("ActiveTransform EndTime Translate .1 0 0 ActiveTransform All\n"), 1);
}

}  // namespace brume::test
