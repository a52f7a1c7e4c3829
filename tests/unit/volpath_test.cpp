// SPDX-License-Identifier: Apache-2.0
// volpath against furnaces, slabs solved by adding-doubling, quadrature and itself. Samples come
// from the sampler "random", so that pixels are independent and their scatter gives the standard
// error. |z| < 4 fails by chance once in 16,000.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/integrator.h"
#include "core/io/image.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/rng.h"
#include "support/adding_doubling.h"
#include "support/estimate.h"
#include "support/make_plugin.h"
#include "support/media_scene.h"
#include "support/render_text.h"
#include "support/run_program.h"

namespace brume {
namespace {

constexpr double kMaxZ = 4;

/// All pixels see the same: the field of view is tiny.
std::string scene(const std::string& lookAt, const std::string& world, int samples,
                  const std::string& params = "") {
  return fmt::format(
      "LookAt {}\nCamera \"perspective\" \"float fov\" [0.001]\n"
      "Film \"image\" \"integer xresolution\" [16] \"integer yresolution\" [16]\n"
      "Sampler \"random\" \"integer pixelsamples\" [{}]\nGlobalIntegrator \"volpath\" {}\n"
      "WorldBegin\n{}\nWorldEnd\n",
      lookAt, samples, params, world);
}

std::string gray(double v) { return fmt::format("[{} {} {}]", v, v, v); }
const std::string kSky = "LightSource \"infinite\" \"color L\" [1 1 1]\n";
const std::string kFromOutside = "4 3 5  .1 .2 .3  0 1 0", kFromInside = ".3 .2 .1  1 2 3  0 1 0";
const std::string kBox = "\"point p0\" [-1 -1 -1] \"point p1\" [1 1 1]";

/// The volume kinds with density 1 everywhere in the box.
std::vector<std::string> equalMedia(const std::string& coefficients) {
  std::string ones;
  for (int i = 0; i < 27; ++i) ones += " 1";
  return {fmt::format("Volume \"homogeneous\" {} {}\n", coefficients, kBox),
          fmt::format("Volume \"volumegrid\" {} {} \"integer nx\" 3 \"integer ny\" 3 \"integer "
                      "nz\" 3 \"float density\" [{}]\n",
                      coefficients, kBox, ones),
          fmt::format("Volume \"exponential\" {} {} \"float b\" 0\n", coefficients, kBox),
          fmt::format("Volume \"homogeneous\" {0} \"point p0\" [-1 -1 -1] \"point p1\" [.2 1 1]\n"
                      "Volume \"homogeneous\" {0} \"point p0\" [.2 -1 -1] \"point p1\" [1 1 1]\n",
                      coefficients)};
}

TEST(VolPath, WhiteFurnace) {
  // Albedo 1 under radiance 1 from everywhere: 1, whatever scatters; chromatic, forward, from
  // outside and inside.
  for (const std::string coefficients : {"\"color sigma_s\" [2 2 2]", "\"color sigma_s\" [.5 2 8]",
                                         "\"color sigma_s\" [3 3 3] \"float g\" .9"})
    for (const std::string& medium : equalMedia(coefficients))
      for (const std::string& lookAt : {kFromOutside, kFromInside}) {
        const auto image = renderText(scene(lookAt, kSky + medium, 8)).image;
        for (const char* channel : {"R", "G", "B"}) {
          const Estimate e = estimateOf(image, channel);
          EXPECT_LT(std::abs(e.z(1)), kMaxZ) << coefficients << medium << " mean " << e.mean;
          EXPECT_LT(e.standardError, 0.05);
        }
      }
}

TEST(VolPath, ThermalEquilibriumHasNoNoise) {
  // A medium that only absorbs and emits sigma_a per unit length, under radiance 1: every ray
  // carries 1.
  for (const std::string& medium : equalMedia("\"color sigma_a\" [.5 2 8] \"color Le\" [.5 2 8]"))
    for (const std::string& lookAt : {kFromOutside, kFromInside}) {
      const Rgb mean = meanOf(renderText(scene(lookAt, kSky + medium, 1)).image);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(mean[c], 1, 1e-5) << medium;  // float rounding of the sum
    }
}

TEST(VolPath, EqualMediaLookEqual) {
  const std::string light = "LightSource \"point\" \"point from\" [.4 2 .2] \"color I\" [3 3 3]\n";
  std::optional<Estimate> first;
  for (const std::string& medium :
       equalMedia("\"color sigma_a\" [.3 .3 .3] \"color sigma_s\" [2 2 2] \"float g\" .6")) {
    const Estimate e = estimateOf(renderText(scene(kFromOutside, light + medium, 64)).image, "G");
    if (!first) first = e;
    EXPECT_LT(std::abs(e.z(*first)), kMaxZ) << medium << e.mean << " against " << first->mean;
    EXPECT_LT(e.standardError, 0.03 * e.mean);
  }
}

/// An infinite slab 0 < z < 1 under a unit sky on the side of +z; a black plane hides the sky from
/// the other side.
std::string slab(double albedo, double g, double tau, double mu, bool litSide, int samples) {
  const double s = std::sqrt(1 - mu * mu);
  const std::string lookAt = litSide ? fmt::format("{} 0 {}  0 0 1  0 1 0", 50 * s, 1 + 50 * mu)
                                     : fmt::format("{} 0 {}  0 0 0  0 1 0", 5e-4 * s, -5e-4 * mu);
  const std::string medium = fmt::format(
      "Volume \"homogeneous\" \"color sigma_a\" {} \"color sigma_s\" {} \"float g\" {} "
      "\"point p0\" [-1e4 -1e4 0] \"point p1\" [1e4 1e4 1]\n",
      gray(tau * (1 - albedo)), gray(tau * albedo), g);
  const std::string plane =
      "Material \"matte\" \"color Kd\" [0 0 0]\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n"
      "  \"point P\" [-2e4 -2e4 -.001  2e4 -2e4 -.001  2e4 2e4 -.001  -2e4 2e4 -.001]\n";
  return scene(lookAt, kSky + medium + plane, samples);
}

TEST(VolPath, SlabsAgreeWithAddingDoubling) {
  struct Case {
    double albedo, g, tau;
  };
  for (const Case c : {Case{0.9, 0.75, 2}, {1, 0, 1}, {0.5, -0.5, 2}, {0.97, 0.85, 5}}) {
    const auto exact = test::solveSlab(c.albedo, c.tau, test::henyeyGreenstein(c.g), {1, 0.5, 0.2});
    for (std::size_t i = 0; i < 3; ++i)
      for (bool lit : {true, false}) {
        const double mu = i == 0 ? 1 : i == 1 ? 0.5 : 0.2, expected = lit ? exact[i].R : exact[i].T;
        const Estimate e =
            estimateOf(renderText(slab(c.albedo, c.g, c.tau, mu, lit, 32)).image, "G");
        EXPECT_LT(std::abs(e.z(expected)), kMaxZ)
            << "albedo " << c.albedo << " g " << c.g << " tau " << c.tau << " mu " << mu
            << (lit ? " R " : " T ") << e.mean << " expected " << expected;
        EXPECT_LT(e.standardError, 0.05 * expected);
      }
  }
}

TEST(VolPath, OneScatteringIsSingleScattering) {
  // Against the volume integrator "single", which is tested against quadrature.
  const std::string world =
      "LightSource \"point\" \"point from\" [.4 2 .2] \"color I\" [3 3 3]\n"
      "Volume \"homogeneous\" \"color sigma_a\" [.3 .3 .3] \"color sigma_s\" [2 2 2] \"float g\" "
      ".6 " +
      kBox + "\n";
  const Estimate e =
      estimateOf(renderText(scene(kFromOutside, world, 256, "\"integer maxdepth\" 1")).image, "G");
  std::string other = scene(kFromOutside, world, 16);
  other.replace(other.find("GlobalIntegrator \"volpath\""), 26, "VolumeIntegrator \"single\"");
  const double single = static_cast<double>(meanOf(renderText(other).image).g);
  EXPECT_LT(std::abs(e.z(single)), kMaxZ) << e.mean << " against " << single;
  EXPECT_LT(e.standardError, 0.02 * single);
}

TEST(VolPath, ComponentsArePartsOfTheWhole) {
  // A glass ball in fog between a floor and a mirror, lit by an area light: every component occurs.
  Log log({Verbosity::Verbose, false, true});
  const auto job = makeJob(
      scene(kFromOutside,
            "AttributeBegin AreaLightSource \"area\" \"color L\" [20 20 20]\n"
            "Translate 0 3 0 Shape \"sphere\" \"float radius\" .3 AttributeEnd\n"
            "AttributeBegin Material \"glass\" Translate 0 1.2 0 Shape \"sphere\" \"float radius\" "
            ".5 AttributeEnd\n"
            "Material \"matte\" Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n"
            "  \"point P\" [-9 -1 -9  -9 -1 9  9 -1 9  9 -1 -9]\n"
            "Volume \"homogeneous\" \"color sigma_s\" [.3 .3 .3] \"color Le\" [.01 .01 .01]\n"
            "  \"point p0\" [-3 -1 -3] \"point p1\" [3 3 3]\n",
            1),
      {}, log);
  IntegratorFactoryContext factory;
  factory.scene = &job->scene();
  const auto volpath = test::make<GlobalIntegrator>("volpath", {}, factory);
  const auto& rays = dynamic_cast<const RayRadiance&>(*volpath);
  ASSERT_TRUE(rays.splitsComponents());

  test::StratifiedStream stream(7);
  Stats stats;
  Rng rng(8);
  ComponentRadiance sums;
  for (int i = 0; i < 20000; ++i) {
    ComponentRadiance components;
    RenderContext context{stream, stats, &components};
    const FootprintRay ray(
        Ray{Vec3(0, 1, 6), normalize(Vec3(rng.uniform() - .5f, rng.uniform() - .7f, -1))});
    const Rgb L = rays.Li(ray, 0, context);
    // The same sums in another order.
    EXPECT_NEAR(components.total().g, L.g, 1e-5f * L.g);
    for (int c = 0; c < kPathComponents; ++c)
      sums.add(PathComponent(c), components[PathComponent(c)]);
  }
  for (int c = 0; c < kPathComponents; ++c)
    EXPECT_GT(sums[PathComponent(c)].g, 0) << componentName(PathComponent(c));
}

/// Every technique may be switched off, and all ways lead to the same mean.
void expectTechniquesAgree(const std::string& world, const std::vector<std::string>& switches,
                           int samples) {
  std::optional<Estimate> first;
  for (const std::string& params : switches) {
    const Estimate e =
        estimateOf(renderText(scene(kFromOutside, world, samples, params)).image, "G");
    if (!first) first = e;
    EXPECT_LT(std::abs(e.z(*first)), kMaxZ)
        << params << ": " << e.mean << " against " << first->mean;
    EXPECT_LT(e.standardError, 0.1 * e.mean) << params;
  }
}

const std::string kMatteFloor =
    "Material \"matte\" Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n"
    "  \"point P\" [-9 -1 -9  -9 -1 9  9 -1 9  9 -1 -9]\n";

TEST(VolPath, TechniquesAgreeOnPointLightsInAMedium) {
  expectTechniquesAgree(
      "LightSource \"point\" \"point from\" [.3 .2 .4] LightSource \"point\" \"point from\" [-.4 "
      ".3 0]\n"
      "LightSource \"point\" \"point from\" [3 4 0] \"color I\" [9 9 9]\n"
      "Volume \"homogeneous\" \"color sigma_s\" [1 2 3] \"color sigma_a\" [.2 .1 0] \"float g\" "
      ".4 " +
          kBox + "\n" + kMatteFloor,
      {"", "\"bool equiangular\" \"false\"", "\"bool towardslights\" \"false\"",
       "\"string lights\" \"even\""},
      64);
}

TEST(VolPath, TechniquesAgreeOnSmallLightsInAMedium) {
  // Two media whose phase functions differ: what a vertex carries decides between them.
  expectTechniquesAgree(
      "AttributeBegin AreaLightSource \"diffuse\" \"color L\" [30 20 10] Translate .3 .2 .4\n"
      "Shape \"sphere\" \"float radius\" .08 AttributeEnd\n"
      "AttributeBegin AreaLightSource \"diffuse\" \"color L\" [10 20 30] Translate -.4 .3 0\n"
      "Rotate 60 1 .5 0 Shape \"disk\" \"float radius\" .1 AttributeEnd\n"
      "Volume \"homogeneous\" \"color sigma_s\" [.1 .2 .3] \"color sigma_a\" [.2 .1 0] \"float g\" "
      ".4 " +
          kBox +
          "\nVolume \"homogeneous\" \"color sigma_s\" [.3 .1 0] \"float g\" -.6 \"point p0\" "
          "[-.2 -1 -1] \"point p1\" [1 .6 1]\n" +
          kMatteFloor,
      {"", "\"bool equiangular\" \"false\"", "\"string lights\" \"even\""}, 256);
}

TEST(VolPath, LightIsTheSameHoweverItIsFound) {
  // A lamp, a sky that is looked at (bright in a ninth of the directions) and one that is not, a
  // flame, matte and glass, in fog that scatters forward.
  const test::TemporaryFolder folder;
  LayeredImage sun;
  sun.displaySize = {8, 4};
  sun.dataWindow = {{0, 0}, sun.displaySize};
  for (const char* c : {"R", "G", "B"}) {
    sun.channels[c].assign(32, .1f);
    sun.channels[c][10] = 20;
  }
  const auto map = folder.path() / "sun.exr";
  writeImage(map, sun, PixelPrecision::Float);
  const std::string world =
      "AttributeBegin AreaLightSource \"diffuse\" \"color L\" [9 9 9] Translate .3 1.2 .4\n"
      "Rotate 80 1 .5 0 Shape \"disk\" \"float radius\" .7 AttributeEnd\n"
      "Volume \"homogeneous\" \"color sigma_s\" [1 2 3] \"color sigma_a\" [.2 .1 0] \"float g\" "
      ".6 " +
      kBox +
      "\nVolume \"homogeneous\" \"color Le\" [30 20 10] \"color sigma_a\" [1 1 1]\n"
      "  \"point p0\" [.5 -.6 .5] \"point p1\" [.8 -.2 .8]\n"
      "AttributeBegin Material \"glass\" Translate 0 -.4 0 Shape \"sphere\" \"float radius\" .4 "
      "AttributeEnd\n" +
      kMatteFloor;
  const std::vector<std::string> switches{
      "", "\"string lightfoundby\" \"looking\"", "\"string lightfoundby\" \"hitting\"",
      "\"bool roulette\" \"false\"",
      "\"string lightfoundby\" \"looking\" \"bool emissionsampling\" \"false\""};
  const std::string sky = "LightSource \"infinite\" \"color L\" [.5 .5 .5]\n";
  expectTechniquesAgree(sky + world, switches, 256);
  expectTechniquesAgree(
      "LightSource \"infinite\" \"string mapname\" \"" + map.string() + "\"\n" + world, switches,
      256);
}

TEST(VolPath, DarkSurfacesAreNoNoisierThanWhiteOnes) {
  // Every path from a floor under an even sky carries the same.
  for (const char* Kd : {"1", ".02", "1e-9"}) {
    const Estimate e = estimateOf(
        renderText(scene("0 .5 0  0 0 0  0 0 1",
                         fmt::format("LightSource \"infinite\" Material \"matte\" \"color Kd\" "
                                     "[{0} {0} {0}] ",
                                     Kd) +
                             kMatteFloor.substr(kMatteFloor.find("Shape")),
                         4))
            .image,
        "G");
    EXPECT_NEAR(e.mean / std::atof(Kd), 1, 1e-5) << Kd;
    EXPECT_LT(e.standardError, 1e-5 * e.mean) << Kd;
  }
}

TEST(VolPath, LooksThatSurviveRouletteArePaidBack) {
  // The sun is behind the viewer and the fog scatters forward: most looks after the first
  // scattering are at light that would be turned far.
  expectTechniquesAgree(
      "LightSource \"distant\" \"point from\" [0 0 5] \"point to\" [0 0 0]\n"
      "Volume \"homogeneous\" \"color sigma_s\" [3 3 3] \"float g\" .8 " +
          kBox,
      {"", "\"bool roulette\" \"false\""}, 1024);
}

TEST(VolPath, RouletteEndsNoPathThatCarriesMuch) {
  // Albedo 1/2: from the third scattering on paths carry less than a third of what the first left.
  const auto counters = [](const std::string& params) {
    return renderText(scene(kFromOutside,
                            "LightSource \"infinite\" Volume \"homogeneous\" \"color sigma_s\" "
                            "[2 2 2] \"color sigma_a\" [2 2 2] " +
                                kBox,
                            4, params))
        .stats;
  };
  EXPECT_GT(counters("")[Stat::RussianRouletteStops], 300u);
  EXPECT_EQ(counters("\"bool roulette\" \"false\"")[Stat::RussianRouletteStops], 0u);
  EXPECT_EQ(counters("\"integer maxdepth\" 1")[Stat::RussianRouletteStops], 0u);
}

TEST(VolPath, TechniquesAgreeOnEmittingMedia) {
  // A small flame beside a smoke that glows a little, over a floor; the flame is partly hidden by a
  // wall and overlaps the smoke.
  expectTechniquesAgree(
      "Volume \"homogeneous\" \"color sigma_s\" [1 1 1] \"color sigma_a\" [.5 .5 .5] \"color Le\" "
      "[.05 .05 .05] " +
          kBox +
          "\nVolume \"exponential\" \"color Le\" [90 60 20] \"color sigma_a\" [3 2 1] \"float b\" "
          "4\n"
          "  \"point p0\" [.7 .5 .6] \"point p1\" [1.2 1.3 1.1]\n"
          "Shape \"disk\" \"float radius\" .5\n" +
          kMatteFloor,
      {"", "\"bool emissionsampling\" \"false\"", "\"string lights\" \"even\""}, 64);
}

TEST(VolPath, RouletteKeepsWhatDirectionsAroundALightGain) {
  // Long paths around a point light in fog that absorbs a little. Light scattered along a ray grows
  // like 1 / its distance D from the lamp; directions drawn around the lamp carry D in return, and
  // roulette must not give it back.
  Log log({Verbosity::Verbose, false, true});
  const auto job = makeJob(
      scene(".6 .6 3  .6 .6 0  0 1 0",
            "LightSource \"point\" \"point from\" [0 0 0]\n"
            "Volume \"homogeneous\" \"color sigma_s\" [4 4 4] \"color sigma_a\" [.1 .1 .1]\n"
            "  \"float g\" .5 \"point p0\" [-1 -1 -1] \"point p1\" [1 1 1]\n",
            1),
      {}, log);
  IntegratorFactoryContext factory;
  factory.scene = &job->scene();
  const auto volpath = test::make<GlobalIntegrator>("volpath", {}, factory);
  const auto& rays = dynamic_cast<const RayRadiance&>(*volpath);
  const FootprintRay ray(Ray{Vec3(0), Vec3(0, 0, -1)});  // the camera is the origin of render space
  // Two streams in which paths pass the lamp at a thousandth of the box: variances relative to the
  // mean squared were 400 and 960 when roulette did, and grew with the number of paths; 145 and 167
  // now.
  for (const std::uint64_t seed : {13, 14}) {
    test::StratifiedStream stream(seed);
    Stats stats;
    RenderContext context{stream, stats, nullptr};
    double sum = 0, squares = 0;
    constexpr int kPaths = 200'000;
    for (int i = 0; i < kPaths; ++i) {
      const double L = double{rays.Li(ray, 0, context).g};
      sum += L / kPaths;
      squares += L * L / kPaths;
    }
    EXPECT_LT(squares, 250 * sum * sum);
    EXPECT_NEAR(sum, .13, .015);  // four standard errors of each stream
  }
}

TEST(VolPath, EmittingMediaLightAWhiteFurnace) {
  // In thermal equilibrium with a medium that scatters too: everything has radiance 1.
  for (const std::string& medium : equalMedia("\"color sigma_a\" [.5 2 8] \"color Le\" [.5 2 8] "
                                              "\"color sigma_s\" [4 1 1] \"float g\" .5")) {
    const auto image = renderText(scene(kFromOutside, kSky + medium, 16)).image;
    for (const char* channel : {"R", "G", "B"}) {
      const Estimate e = estimateOf(image, channel);
      EXPECT_LT(std::abs(e.z(1)), kMaxZ) << medium << " mean " << e.mean;
      EXPECT_LT(e.standardError, 0.02);
    }
  }
}

TEST(VolPath, SamplingASmallFlamePays) {
  // A floor lit by a flame of a tenth of its distance: by chance alone few paths find it.
  const std::string world =
      "Volume \"homogeneous\" \"color Le\" [500 500 500] \"color sigma_a\" [1 1 1]\n"
      "  \"point p0\" [-.1 .9 -.1] \"point p1\" [.1 1.1 .1]\n" +
      kMatteFloor;
  const std::string below = "4 3 5  .1 -1 .2  0 1 0";
  const auto error = [&](const std::string& params) {
    const Estimate e = estimateOf(renderText(scene(below, world, 32, params)).image, "G");
    return e.standardError / e.mean;
  };
  EXPECT_LT(5 * error(""), error("\"bool emissionsampling\" \"false\""));
}

TEST(VolPath, LayersAddUpToTheImage) {
  const std::string world =
      kSky + "LightSource \"point\" \"point from\" [.4 2 .2]\n" + kMatteFloor +
      "AttributeBegin Material \"mirror\" Shape \"sphere\" \"float radius\" .5 AttributeEnd\n"
      "Volume \"homogeneous\" \"color sigma_s\" [1 1 1] " +
      kBox + "\n";
  std::string text = scene("4 3 5  0 0 0  0 1 0", world, 4);
  text.replace(text.find("0.001"), 5, "60");  // see all of it
  RenderSettings settings;
  settings.layers = true;
  const auto image = renderText("PixelFilter \"box\"\n" + text, settings).image;
  const auto plain = renderText("PixelFilter \"box\"\n" + text).image;
  double transmittances = 0;
  for (std::size_t i = 0; i < image.channels.at("R").size(); ++i) {
    for (const char* c : {"R", "G", "B"}) {
      EXPECT_EQ(image.channels.at(c)[i], plain.channels.at(c)[i]);  // layers change nothing
      float sum = 0;
      for (int k = 0; k < kPathComponents; ++k)
        sum += image.channels.at(std::string(componentName(PathComponent(k))) + "." + c)[i];
      EXPECT_NEAR(sum, image.channels.at(c)[i], 1e-5f * (1 + sum));  // rounding
    }
    const float depth = image.channels.at("depth.Z")[i];
    if (std::isinf(depth)) {
      EXPECT_EQ(image.channels.at("albedo.G")[i], 0);
    } else {
      EXPECT_GT(depth, 3);
      EXPECT_LT(depth, 30);
    }
    transmittances += double{image.channels.at("transmittance.G")[i]};
  }
  EXPECT_LT(transmittances, 0.97 * 256);  // the box of fog fills a part of the image
  EXPECT_GT(transmittances, 0.1 * 256);
}

TEST(VolPath, LayersOfTheFirstSurface) {
  // A matte floor seen straight from above, through one optical depth of absorption.
  const std::string world =
      kMatteFloor + "Volume \"homogeneous\" \"color sigma_a\" [.5 .5 .5] " + kBox;
  RenderSettings settings;
  settings.layers = true;
  const auto image = renderText(scene("0 4 0  0 0 0  1 0 0", world, 4), settings).image;
  const auto all = [&](const char* name, double expected, double tolerance) {
    for (float v : image.channels.at(name)) EXPECT_NEAR(v, expected, tolerance) << name;
  };
  all("depth.Z", 5, 1e-4);
  all("normal.X", 0, 1e-5);
  for (float v : image.channels.at("normal.Y")) EXPECT_NEAR(std::abs(v), 1, 1e-5);
  all("albedo.R", 0.5, 2e-3);  // 16 stratified directions; half precision
  all("transmittance.R", std::exp(-1.0), 1e-3);
}

TEST(VolPath, SaysWhatItCannotFind) {
  const std::string point = "LightSource \"point\"\n",
                    glass = "Material \"glass\" Shape \"sphere\"\n";
  const auto warns = [](const std::string& world) {
    Log log({Verbosity::Verbose, false, true});
    const auto job = makeJob(scene(kFromOutside, world, 1), {}, log);
    for (const std::string& line : job->plan())
      if (line.starts_with("skip  light without extent through glass")) return true;
    return false;
  };
  EXPECT_TRUE(warns(point + glass));
  EXPECT_FALSE(warns(point + "Shape \"sphere\"\n"));
  EXPECT_FALSE(warns(kSky + glass));
}

TEST(VolPath, SurfacesWithoutMediaArePathTraced) {
  // A closed box of reflectance rho that emits Le: Le / (1 - rho), a geometric series without end.
  const std::string world =
      "AreaLightSource \"area\" \"color L\" [.5 .5 .5]\nMaterial \"matte\" \"color Kd\" [.5 .5 "
      ".5]\n"
      "ReverseOrientation\nShape \"sphere\" \"float radius\" 2\n";
  const Estimate e = estimateOf(renderText(scene(kFromInside, world, 64)).image, "G");
  EXPECT_LT(std::abs(e.z(1)), kMaxZ) << e.mean;
  EXPECT_LT(e.standardError, 0.01);
}

TEST(VolPath, LightsInObjectInstancesLightNothing) {
  // As for all integrators: no light is sampled there, and what hits it by chance does not count.
  const auto image =
      renderText(scene("0 0 5  0 0 0  0 1 0",
                       "ObjectBegin \"lamp\" AreaLightSource \"diffuse\" \"color L\" [10 10 10]\n"
                       "Shape \"sphere\" \"float radius\" .9 ObjectEnd\n"
                       "Shape \"disk\" Translate 1.2 0 1 ObjectInstance \"lamp\"\n",
                       16))
          .image;
  for (const float v : image.channels.at("R")) EXPECT_EQ(v, 0);
}

TEST(VolPath, ClosedSceneWithoutLossEnds) {
  const std::string world =
      "Material \"matte\" \"color Kd\" [1 1 1]\nShape \"sphere\" \"float radius\" 2\n"
      "Volume \"homogeneous\" \"color sigma_s\" [1 1 1] " +
      kBox + "\n";
  std::string text = scene(kFromInside, world, 1);
  text.replace(text.find("[16] \"integer yres"), 4, "[1]");
  text.replace(text.find("yresolution\" [16]") + 13, 4, "[1]");
  EXPECT_EQ(meanOf(renderText(text).image), Rgb());  // nothing shines
}

TEST(VolPath, DoesNotDependOnThreads) {
  const std::string text = slab(0.9, 0.75, 2, 0.5, true, 2);
  std::optional<std::vector<float>> first;
  for (int threads : {1, 2, 7}) {
    setThreadCount(threads);
    const auto image = renderText(text).image;
    if (!first) first = image.channels.at("G");
    EXPECT_EQ(image.channels.at("G"), *first);
  }
  setThreadCount(0);
}

}  // namespace
}  // namespace brume
