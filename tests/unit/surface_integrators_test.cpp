// SPDX-License-Identifier: Apache-2.0
// Closed forms and furnaces for whitted, directlighting, path and ambientocclusion.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "support/render_text.h"

namespace brume {
namespace {

/// A scene with a camera of a tiny field of view, so that all pixels see one point.
std::string scene(const std::string& integrator, const std::string& lookAt,
                  const std::string& world, int samples = 1, int resolution = 1) {
  return fmt::format(
      "LookAt {}\nCamera \"perspective\" \"float fov\" [0.01]\n"
      "Film \"image\" \"integer xresolution\" [{}] \"integer yresolution\" [{}]\n"
      "Sampler \"lowdiscrepancy\" \"integer pixelsamples\" [{}]\n"
      "SurfaceIntegrator {}\nWorldBegin\n{}\nWorldEnd\n",
      lookAt, resolution, resolution, samples, integrator, world);
}

const std::string kFloor =
    "Material \"matte\" \"color Kd\" [.5 .5 .5]\n"
    "Shape \"trianglemesh\" \"integer indices\" [0 1 2 2 3 0]\n"
    "  \"point P\" [-50 -50 0  50 -50 0  50 50 0  -50 50 0]\n";
/// Sees the floor's origin from the side, so that lights above do not hide it.
const std::string kFromSide = "8 0 1  0 0 0  0 0 1";

float renderValue(const std::string& text, const RenderSettings& settings = {}) {
  const Rgb mean = meanOf(renderText(text, settings).image);
  EXPECT_NEAR(mean.r, mean.b, 1e-4f * mean.r);
  return mean.g;
}

class DirectLight : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Integrators, DirectLight,
                         testing::Values("\"whitted\"", "\"directlighting\"",
                                         "\"directlighting\" \"string strategy\" \"one\"",
                                         "\"path\"", "\"path\" \"integer maxdepth\" [0]"));

TEST_P(DirectLight, PointLightOnAPlane) {
  const std::string light = "LightSource \"point\" \"color I\" [10 10 10] \"point from\" [1 0 2]\n";
  const double expected = .5 / M_PI * 10 / 5 * 2 / std::sqrt(5.0);
  // No noise; the pixel is 1.4e-3 wide at the camera's distance, and at the grazing angle of 1 in 8
  // covers 1.1e-2 of the floor, half to each side, over which 1/d^2 changes by its double over d.
  EXPECT_NEAR(renderValue(scene(GetParam(), kFromSide, light + kFloor)), expected, 5e-3 * expected);
}

TEST_P(DirectLight, DistantLightOnAPlane) {
  const std::string light =
      "LightSource \"distant\" \"color L\" [3 3 3] \"point from\" [1 0 1] \"point to\" [0 0 0]\n";
  const double expected = .5 / M_PI * 3 * std::sqrt(.5);
  EXPECT_NEAR(renderValue(scene(GetParam(), kFromSide, light + kFloor)), expected, 1e-4 * expected);
}

TEST_P(DirectLight, DiskLightOnItsAxis) {
  const std::string light =
      "AttributeBegin AreaLightSource \"area\" \"color L\" [4 4 4] Translate 0 0 2 Rotate 180 1 0 "
      "0\n"
      "Material \"matte\" \"color Kd\" [0 0 0] Shape \"disk\" \"float radius\" [1] AttributeEnd\n";
  const double expected = .5 * 4 * 1 / (1 + 4.0);  // Kd/pi E, E = pi L R^2 / (R^2 + h^2)
  // 4096 stratified samples of an integrand with a relative deviation below 0.3.
  EXPECT_NEAR(renderValue(scene(GetParam(), kFromSide, light + kFloor, 4096)), expected,
              5e-3 * expected);
  // Seen from behind it is black.
  const std::string turned =
      "AttributeBegin AreaLightSource \"area\" \"color L\" [4 4 4] Translate 0 0 2\n"
      "Material \"matte\" \"color Kd\" [0 0 0] Shape \"disk\" \"float radius\" [1] AttributeEnd\n";
  EXPECT_EQ(renderValue(scene(GetParam(), kFromSide, turned + kFloor, 16)), 0.f);
}

TEST_P(DirectLight, SphereLightAboveAPlane) {
  const std::string light =
      "AttributeBegin AreaLightSource \"area\" \"color L\" [4 4 4] Translate 0 0 3\n"
      "Material \"matte\" \"color Kd\" [0 0 0] Shape \"sphere\" \"float radius\" [1] "
      "AttributeEnd\n";
  const double expected = .5 * 4 * 1 / 9.0;  // E = pi L r^2 / h^2
  EXPECT_NEAR(renderValue(scene(GetParam(), kFromSide, light + kFloor, 4096)), expected,
              5e-3 * expected);
}

TEST_P(DirectLight, UniformEnvironmentOnAPlane) {
  const std::string light = "LightSource \"infinite\" \"color L\" [2 2 2]\n";
  // whitted samples the map alone: the cosine's deviation over 4096 stratified samples.
  EXPECT_NEAR(renderValue(scene(GetParam(), kFromSide, light + kFloor, 4096)), 1.0, 1e-2);
}

TEST_P(DirectLight, MediaAttenuateBothSegments) {
  const std::string light = "LightSource \"point\" \"color I\" [10 10 10] \"point from\" [1 0 2]\n";
  const std::string fog =
      "Volume \"homogeneous\" \"color sigma_a\" [.2 .2 .2] \"point p0\" [-60 -60 -60]\n"
      "  \"point p1\" [60 60 60]\n";
  const double direct = .5 / M_PI * 10 / 5 * 2 / std::sqrt(5.0);
  const double expected = direct * std::exp(-.2 * (std::sqrt(65.0) + std::sqrt(5.0)));
  EXPECT_NEAR(renderValue(scene(GetParam(), kFromSide, light + fog + kFloor)), expected,
              5e-3 * expected);  // as for the point light without media
}

TEST_P(DirectLight, MirrorShowsTheEmitter) {
  // The camera's ray meets the mirror at the origin and goes up to the panel.
  const std::string world =
      "AttributeBegin Material \"mirror\" \"color Kr\" [.7 .7 .7]\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2]\n"
      "  \"point P\" [-2 -2 0  2 -2 0  0 4 0] AttributeEnd\n"
      "AttributeBegin AreaLightSource \"area\" \"color L\" [4 4 4] Translate -8 0 1\n"
      "Material \"matte\" \"color Kd\" [0 0 0] Shape \"sphere\" \"float radius\" [.5] "
      "AttributeEnd\n";
  const std::string text = scene(GetParam(), kFromSide, world, 4);
  const bool follows = std::string(GetParam()).find("[0]") == std::string::npos;
  EXPECT_NEAR(renderValue(text), follows ? .7 * 4 : 0.0, 1e-4);
}

TEST_P(DirectLight, GlassPaneTransmits) {
  // A pane of index 1.5 at normal incidence: T = (1 - F) / (1 + F), F = 0.04, all orders.
  const std::string name = std::string(GetParam()).find("path") != std::string::npos
                               ? "\"path\""
                               : std::string(GetParam());
  const std::string world =
      "AttributeBegin Material \"glass\"\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2]\n"
      "  \"point P\" [0 -9 -9  0 9 -9  0 0 9] \n"
      "ReverseOrientation Shape \"trianglemesh\" \"integer indices\" [0 1 2]\n"
      "  \"point P\" [-1 -9 -9  -1 9 -9  -1 0 9] AttributeEnd\n"
      "AttributeBegin AreaLightSource \"area\" \"color L\" [4 4 4] Translate -8 0 0\n"
      "Material \"matte\" \"color Kd\" [0 0 0] Shape \"sphere\" \"float radius\" [.5] "
      "AttributeEnd\n";
  const std::string text =
      scene(name + " \"integer maxdepth\" [30]", "8 0 0  0 0 0  0 0 1", world, 4096);
  const double expected = 4 * (1 - .04) / (1 + .04);
  // path chooses between reflection and refraction: a binomial of p = 0.5 weighted by up to 2 per
  // interface; 4096 stratified samples of relative deviation 1.7 give 2.7 %.
  const bool chooses = name == "\"path\"";
  EXPECT_NEAR(renderValue(text), expected, expected * (chooses ? 0.08 : 0.004));
}

TEST_P(DirectLight, SameBitsForAnyNumberOfThreads) {
  const std::string world =
      "LightSource \"infinite\" \"color L\" [.5 .5 .5]\n"
      "AttributeBegin AreaLightSource \"area\" \"color L\" [4 4 4] Translate 0 0 3\n"
      "Shape \"sphere\" \"float radius\" [.7] AttributeEnd\n"
      "AttributeBegin Material \"glass\" Translate 0 0 1 Shape \"sphere\" AttributeEnd\n" +
      kFloor;
  const std::string text = fmt::format(
      "LookAt 8 0 3  0 0 1  0 0 1\nCamera \"perspective\" \"float fov\" [40]\n"
      "Film \"image\" \"integer xresolution\" [40] \"integer yresolution\" [40]\n"
      "PixelFilter \"gaussian\"\nSampler \"lowdiscrepancy\" \"integer pixelsamples\" [4]\n"
      "SurfaceIntegrator {}\nWorldBegin\n{}\nWorldEnd\n",
      GetParam(), world);
  setThreadCount(1);
  const auto one = renderText(text).image.channels;
  for (const int threads : {2, 7}) {
    setThreadCount(threads);
    EXPECT_EQ(renderText(text).image.channels, one) << threads << " threads";
  }
  setThreadCount(0);
}

/// Six walls of a unit cube that emit 1 and reflect rho, seen from within.
std::string closedBox(double rho) {
  std::string walls = fmt::format(
      "AreaLightSource \"area\" \"color L\" [1 1 1]\n"
      "Material \"matte\" \"color Kd\" [{0} {0} {0}]\n",
      rho);
  for (const char* turn : {"Rotate 0 1 0 0", "Rotate 90 1 0 0", "Rotate 180 1 0 0",
                           "Rotate 270 1 0 0", "Rotate 90 0 1 0", "Rotate 270 0 1 0"})
    walls += fmt::format(
        "AttributeBegin {} Shape \"trianglemesh\" \"integer indices\" [0 1 2 2 3 0]\n"
        "\"point P\" [-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1] AttributeEnd\n",
        turn);
  return walls;
}

TEST(PathIntegrator, ClosedEmittingBoxIsAGeometricSeries) {
  const double rho = 0.6;
  for (const int maxdepth : {0, 1, 2, 3, 5, 8}) {
    double expected = 0;
    for (int k = 0; k <= maxdepth + 1; ++k) expected += std::pow(rho, k);
    const std::string integrator = fmt::format("\"path\" \"integer maxdepth\" [{}]", maxdepth);
    // Noise only from direct light and roulette: relative deviation below 0.5 per path, 16384
    // paths: 0.4 %; 3 sigma.
    EXPECT_NEAR(renderValue(scene(integrator, "0 0 0  .3 .2 1  0 1 0", closedBox(rho), 1024, 4)),
                expected, 0.012 * expected)
        << "maxdepth " << maxdepth;
  }
}

TEST(PathIntegrator, LongPathsReachTheLimit) {
  const std::string integrator = "\"path\" \"integer maxdepth\" [1000]";
  EXPECT_NEAR(renderValue(scene(integrator, "0 0 0  .3 .2 1  0 1 0", closedBox(0.5), 1024, 4)), 2.0,
              0.02);
}

TEST(PathIntegrator, WhiteFurnace) {
  // An open box of albedo 1 in a uniform environment of radiance 1 is invisible.
  std::string cup =
      "LightSource \"infinite\" \"color L\" [1 1 1]\n"
      "Material \"matte\" \"color Kd\" [1 1 1]\n";
  for (const char* turn : {"Rotate 0 1 0 0", "Rotate 90 1 0 0", "Rotate 270 1 0 0",
                           "Rotate 90 0 1 0", "Rotate 270 0 1 0"})
    cup += fmt::format(
        "AttributeBegin {} Shape \"trianglemesh\" \"integer indices\" [0 1 2 2 3 0]\n"
        "\"point P\" [-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1] AttributeEnd\n",
        turn);
  const std::string integrator = "\"path\" \"integer maxdepth\" [10000]";
  // Paths end by leaving the cup alone; the noise is that of the weights of direct light.
  EXPECT_NEAR(renderValue(scene(integrator, "0 0 4  .3 .2 -1  0 1 0", cup, 1024, 4)), 1.0, 0.01);
}

TEST(PathIntegrator, ConvexFurnaceIsExact) {
  for (const double rho : {0.0, 0.3, 1.0}) {
    const std::string world = fmt::format(
        "LightSource \"infinite\" \"color L\" [1 1 1]\n"
        "Material \"matte\" \"color Kd\" [{0} {0} {0}] Shape \"sphere\"\n",
        rho);
    EXPECT_NEAR(renderValue(scene("\"path\"", "0 0 5  .3 .2 0  0 1 0", world, 1024, 2)), rho,
                0.01 * rho);
  }
}

TEST(PathIntegrator, GlassFurnace) {
  // Without absorption and without scaling of radiance a glass sphere in a unit environment is 1.
  const std::string world =
      "LightSource \"infinite\" \"color L\" [1 1 1]\n"
      "Material \"glass\" Shape \"sphere\"\n";
  for (const char* name : {"\"path\"", "\"directlighting\"", "\"whitted\""}) {
    const std::string integrator = fmt::format("{} \"integer maxdepth\" [64]", name);
    EXPECT_NEAR(renderValue(scene(integrator, "0 0 5  .3 .2 0  0 1 0", world, 1024, 4)), 1.0, 0.03)
        << name;
  }
}

TEST(DirectLighting, OneAndAllAgreeOnManyLights) {
  std::string lights;
  for (int i = 0; i < 12; ++i)
    lights += fmt::format(
        "LightSource \"point\" \"color I\" [{0} {0} {0}] \"point from\" [{1} {2} {3}]\n",
        0.2 * (i + 1), std::cos(i) * 3, std::sin(i) * 3, 0.5 + 0.3 * i);
  const double all = renderValue(scene("\"directlighting\"", kFromSide, lights + kFloor));
  const double one = renderValue(
      scene("\"directlighting\" \"string strategy\" \"one\"", kFromSide, lights + kFloor, 4096, 2));
  // Lights are chosen nearly in proportion to what they give: relative deviation about 1, 16384
  // samples: 0.8 %; 3 sigma.
  EXPECT_NEAR(one, all, 0.024 * all);
}

TEST(AmbientOcclusion, DiskAboveAPoint) {
  const std::string disk =
      "AttributeBegin Translate 0 0 1 Shape \"disk\" \"float radius\" [1] "
      "AttributeEnd\n";
  const std::string integrator = "\"ambientocclusion\" \"integer nsamples\" [4096]";
  // Clear share of the hemisphere: 1 - (1 - cos 45 degrees).
  EXPECT_NEAR(renderValue(scene(integrator, kFromSide, disk + kFloor, 4)), std::sqrt(0.5), 0.01);
  EXPECT_EQ(renderValue(scene(integrator + " \"float maxdist\" [.9]", kFromSide, disk + kFloor)),
            1.f);
}

TEST(AmbientOcclusion, ScaleDoesNotMatter) {
  // PBRT-v2's fixed offset of 0.01 made small scenes white.
  for (const double s : {1e-4, 1.0, 1e4}) {
    const std::string text = fmt::format(
        "LookAt {} 0 {}  0 0 0  0 0 1\nCamera \"perspective\" \"float fov\" [0.01]\n"
        "Film \"image\" \"integer xresolution\" [1] \"integer yresolution\" [1]\n"
        "SurfaceIntegrator \"ambientocclusion\"\nWorldBegin\nScale {} {} {}\n"
        "AttributeBegin Translate 0 0 1 Shape \"disk\" \"float radius\" [1] AttributeEnd\n{}\n"
        "WorldEnd\n",
        8 * s, s, s, s, s, kFloor);
    EXPECT_NEAR(renderValue(text), std::sqrt(0.5), 0.01) << "scale " << s;
  }
}

}  // namespace
}  // namespace brume
