// SPDX-License-Identifier: Apache-2.0
// Transmittance, emission and single scattering against formulas and plain quadrature.
#include <gtest/gtest.h>

#include <cmath>

#include "support/boxes.h"
#include "support/slab_cases.h"

namespace brume::test {
namespace {

constexpr double kFourPi = 12.5663706143591729539;

class ClosedForm : public testing::TestWithParam<Method> {};
std::string nameOf(const testing::TestParamInfo<Method>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(Quick, ClosedForm, testing::ValuesIn(judgedMethods()), nameOf);

/// No noise: only float rounding of the sums.
void expectExactly(const Method& method, const SuiteScene& scene,
                   const std::array<double, 3>& expected, double tolerance,
                   const std::string& what) {
  const Measurement m = measure(method, scene, {});
  EXPECT_EQ(m.faults, 0u) << what;
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(m.channels[c].mean, expected[c], tolerance * expected[c]) << what << " " << c;
}

TEST_P(ClosedForm, AbsorbingSlabsFollowBeerAndLambert) {
  for (const Build build :
       {Build::Homogeneous, Build::Exponential, Build::Grid, Build::Split, Build::Overlap})
    for (const double mu : {1.0, 0.6, 0.25}) {
      const SlabMedium medium{{0.01, 1, 6}, gray3(0), henyeyGreensteinCase(0), build};
      std::array<double, 3> expected;
      for (std::size_t c = 0; c < 3; ++c) expected[c] = std::exp(-medium.tau[c] / mu);
      // exp(-24) of a float optical depth: 24 roundings.
      expectExactly(GetParam(), {slabView(mu, true), sky() + volumesOf(medium, 1e4)}, expected,
                    1e-5, nameOf(build));
    }
}

TEST_P(ClosedForm, EmittingSlabsFollowKirchhoff) {
  // Le = B sigma_a: B (1 - exp(-tau / mu)) whatever the density does.
  for (const Build build :
       {Build::Homogeneous, Build::Exponential, Build::Grid, Build::Split, Build::Overlap})
    for (const double mu : {1.0, 0.25}) {
      const SlabMedium medium{{0.01, 1, 6}, gray3(0), henyeyGreensteinCase(0), build, 3};
      std::array<double, 3> expected;
      for (std::size_t c = 0; c < 3; ++c) expected[c] = -3 * std::expm1(-medium.tau[c] / mu);
      expectExactly(GetParam(), {slabView(mu, true), volumesOf(medium, 1e4)}, expected, 1e-5,
                    nameOf(build));
    }
}

using Point = std::array<double, 3>;

/// What is let through between two points of the box's surface by a grid that absorbs, `density` of
/// a point by a fine midpoint rule; `grid` is its text for given coefficients.
template <class Density, class Grid>
void expectLetThrough(const Method& method, const Point& in, const Point& out,
                      const Density& density, const Grid& grid, double tolerance) {
  constexpr int kSteps = 400000;
  double length2 = 0, depth = 0;
  for (std::size_t a = 0; a < 3; ++a) length2 += (out[a] - in[a]) * (out[a] - in[a]);
  for (int i = 0; i < kSteps; ++i) {
    const double s = (i + 0.5) / kSteps;
    depth += density(Point{in[0] + s * (out[0] - in[0]), in[1] + s * (out[1] - in[1]),
                           in[2] + s * (out[2] - in[2])});
  }
  depth *= std::sqrt(length2) / kSteps;
  const std::string lookAt =
      fmt::format("{} {} {}  {} {} {}  0 1 0", 2 * in[0] - out[0], 2 * in[1] - out[1],
                  2 * in[2] - out[2], out[0], out[1], out[2]);
  const Point sigma = {0.2, 1, 3};
  Point expected;
  for (std::size_t c = 0; c < 3; ++c) expected[c] = std::exp(-sigma[c] * depth);
  // The field of view of a thousandth of a degree spans 1e-5 of the density.
  expectExactly(method, {lookAt, sky() + grid("\"color sigma_a\" " + rgbText(sigma)), 1e-5},
                expected, tolerance, lookAt);
}

TEST_P(ClosedForm, UnevenGridsAreIntegratedExactly) {
  const auto density = [](const Point& p) { return unevenDensity(p[0], p[1], p[2]); };
  const auto grid = [](const std::string& coefficients) { return unevenGrid(coefficients); };
  // From the middle of one face of the box to that of another, and between corners.
  const std::array<Point, 2> kRays[] = {{{{0.1, 0.2, 1}, {-0.3, -0.4, -1}}},
                                        {{{1, 1, 1}, {-1, -1, -1}}},
                                        {{{-1, 0.3, -1}, {1, 0.3, 1}}}};
  for (const auto& [in, out] : kRays) expectLetThrough(GetParam(), in, out, density, grid, 1e-4);
}

/// A long grid, empty but for two walls that are not even: whole blocks of it are stepped over.
class WalledGrid {
 public:
  std::string text(const std::string& coefficients) const {
    std::string result = fmt::format(
        "Volume \"volumegrid\" {} \"point p0\" [-1 -1 -1] \"point p1\" [1 1 1] \"integer nx\" {} "
        "\"integer ny\" {} \"integer nz\" {} \"float density\" [",
        coefficients, kSize[0], kSize[1], kSize[2]);
    for (int z = 0; z < kSize[2]; ++z)
      for (int y = 0; y < kSize[1]; ++y)
        for (int x = 0; x < kSize[0]; ++x) result += fmt::format("{:g} ", voxel(x, y, z));
    return result + "]\n";
  }
  /// Trilinear between the voxels' centres, constant beyond the outer ones.
  double at(const Point& p) const {
    double sum = 0;
    std::array<int, 3> low;
    std::array<double, 3> part;
    for (std::size_t a = 0; a < 3; ++a) {
      const double place = std::clamp((p[a] + 1) / 2 * kSize[a] - 0.5, 0.0, kSize[a] - 1.0);
      low[a] = std::min(static_cast<int>(place), kSize[a] - 2);
      part[a] = place - low[a];
    }
    for (int i = 0; i < 8; ++i) {
      const int x = i & 1, y = i >> 1 & 1, z = i >> 2;
      sum += (x ? part[0] : 1 - part[0]) * (y ? part[1] : 1 - part[1]) *
             (z ? part[2] : 1 - part[2]) * voxel(low[0] + x, low[1] + y, low[2] + z);
    }
    return sum;
  }

 private:
  static constexpr std::array<int, 3> kSize = {200, 12, 10};
  static double voxel(int x, int y, int z) {
    const bool isWall = (x >= 20 && x < 25) || (x >= 150 && x < 151);
    return isWall ? 8 + (7 * x + 3 * y + 5 * z) % 9 : 0;
  }
};

TEST_P(ClosedForm, NothingIsLostBetweenEmptyBlocks) {
  const WalledGrid walled;
  const auto density = [&](const Point& p) { return walled.at(p); };
  const auto grid = [&](const std::string& coefficients) { return walled.text(coefficients); };
  // Along the grid, and along the first wall.
  const std::array<Point, 2> kRays[] = {{{{-1, -0.3, 0.1}, {1, 0.4, -0.5}}},
                                        {{{1, 0.9, 0.9}, {-1, -0.9, -0.9}}},
                                        {{{-0.83, 1, 0.2}, {-0.76, -1, -0.3}}}};
  for (const auto& [in, out] : kRays) expectLetThrough(GetParam(), in, out, density, grid, 2e-4);
}

TEST_P(ClosedForm, MovingShapesHideTheSkyForTheirTime) {
  // A black wall passes behind fog that absorbs: it is in the way from t = 0.25 to 0.5.
  const std::string wall =
      "AttributeBegin Material \"matte\" \"color Kd\" [0 0 0]\n"
      "ActiveTransform EndTime Translate 4 0 0 ActiveTransform All\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n"
      "\"point P\" [-2 -1 -2  -1 -1 -2  -1 1 -2  -2 1 -2] AttributeEnd\n";
  const std::array<double, 3> sigma = {0.1, 0.5, 1};
  std::array<double, 3> expected;
  for (std::size_t c = 0; c < 3; ++c) expected[c] = 0.75 * std::exp(-2 * sigma[c]);
  expectRadiance(GetParam(),
                 {"0 0 5  0 0 0  0 1 0",
                  sky() + wall + "Volume \"homogeneous\" \"color sigma_a\" " + rgbText(sigma) +
                      " \"point p0\" [-1 -1 -1] \"point p1\" [1 1 1]\n"},
                 expected, Form::Quick, "wall");
}

/// A disk that shines evenly, over a floor of albedo 1/2 at the origin.
struct DiskLight {
  std::string name, placed;
  double formFactor;  ///< irradiance of the floor at the origin over pi L
};

/// Parallel to the floor at the height h, its centre r to the side, or upright at the distance r
/// with its centre at the height h; of radius a. Source: Howell's catalogue, a differential element
/// and a disk in parallel and in perpendicular planes.
DiskLight parallelDisk(double a, double h, double r) {
  const double H = h / r, R = a / r, Z = 1 + H * H + R * R;
  return {
      fmt::format("parallel {} {} {}", a, h, r),
      fmt::format("Translate {} 0 {} Rotate 180 1 0 0 Shape \"disk\" \"float radius\" {}", r, h, a),
      0.5 * (1 - (Z - 2 * R * R) / std::sqrt(Z * Z - 4 * R * R))};
}
DiskLight uprightDisk(double a, double h, double r) {
  const double H = r / h, R = a / h, Z = 1 + H * H + R * R;
  return {
      fmt::format("upright {} {} {}", a, h, r),
      fmt::format("Translate {} 0 {} Rotate -90 0 1 0 Shape \"disk\" \"float radius\" {}", r, h, a),
      0.5 * H * (Z / std::sqrt(Z * Z - 4 * R * R) - 1)};
}

/// The judged method and those of PBRT-v2, whose light sampling is the same code.
std::vector<Method> withSurfaceIntegrators(const Method& judged) {
  return {judged,
          {"path", "SurfaceIntegrator \"path\""},
          {"directlighting", "SurfaceIntegrator \"directlighting\""}};
}

TEST_P(ClosedForm, DiskLightsShineByTheirFormFactor) {
  for (const Method& method : withSurfaceIntegrators(GetParam()))
    for (const DiskLight& disk :
         {parallelDisk(0.05, 1, 2), parallelDisk(1, 0.5, 0.7), parallelDisk(0.5, 2, 0.1),
          uprightDisk(0.1, 0.3, 1), uprightDisk(0.8, 0.9, 0.4), uprightDisk(0.5, 0.5, 3)}) {
      const std::string light =
          "AttributeBegin Material \"matte\" \"color Kd\" [0 0 0]\n"
          "AreaLightSource \"diffuse\" \"color L\" [1 2 3] " +
          disk.placed + " AttributeEnd\n";
      const double seen = 0.5 * disk.formFactor;
      expectRadiance(method, {"0 -3 0.2  0 0 0  0 0 1", floorAt(0, 50, 0.5) + light},
                     {seen, 2 * seen, 3 * seen}, Form::Quick, method.name + " " + disk.name);
    }
}

TEST_P(ClosedForm, LightsInThePlaneOfACeilingLoseNothing) {
  // Rounding decides whether a ray meets the ceiling or the light first: a disk in a ceiling of two
  // triangles, and one of triangles in a ceiling of many.
  const double h = 1.7, a = 0.9, r = 0.4;
  const DiskLight disk = parallelDisk(a, h, r);
  std::string fine = "Shape \"trianglemesh\" \"integer indices\" [", points;
  constexpr int kFan = 60;
  for (int i = 0; i < kFan; ++i) {
    const double angle = 2 * M_PI * i / kFan;
    fine += fmt::format("0 {} {} ", 1 + i, 1 + (i + 1) % kFan);
    points += fmt::format("{} {} 0 ", a * std::cos(angle), a * std::sin(angle));
  }
  fine += "] \"point P\" [0 0 0 " + points + "]\n";
  // The polygon is smaller than the disk it stands in.
  const double polygon = kFan / (2 * M_PI) * std::sin(2 * M_PI / kFan);
  const std::string black = "Material \"matte\" \"color Kd\" [0 0 0]\n";
  const std::string lamp = "AreaLightSource \"diffuse\" \"color L\" [1 1 1]\n";
  const std::string there =
      fmt::format("Translate {} 0 {} Rotate 90 0 0 1 Rotate 180 1 0 0 ", r, h);
  for (const Method& method : withSurfaceIntegrators(GetParam()))
    for (const bool isMesh : {false, true}) {
      const std::string light = "AttributeBegin " + black + lamp +
                                (isMesh ? there + fine : disk.placed) + "\nAttributeEnd\n";
      const double seen = 0.5 * disk.formFactor * (isMesh ? polygon : 1);
      expectRadiance(method,
                     {"0.2 -3 0.2  0 0 0  0 0 1", floorAt(0, 50, 0.5) + light + floorAt(h, 20, 0)},
                     gray3(seen), Form::Quick, method.name + (isMesh ? " mesh" : " disk"));
      // From below the light is seen in all of its shape.
      expectRadiance(method,
                     {fmt::format("0.3 0.1 0  0.5 -0.2 {}  0 1 0", h), light + floorAt(h, 20, 0)},
                     gray3(1), Form::Quick, method.name + " seen");
    }
}

class OneScattering : public testing::TestWithParam<std::tuple<PhaseCase, Form>> {};

TEST_P(OneScattering, OfParallelLightInASlab) {
  // albedo p(cos) / (4 pi mu) / (1/mu + 1/mu0) (1 - exp(-tau (1/mu + 1/mu0))) on the lit side.
  const auto& [phase, form] = GetParam();
  const Method method{"volpath", "GlobalIntegrator \"volpath\" \"integer maxdepth\" 1"};
  const double tau = 0.8, albedo = 0.7, mu = 0.6;
  const SlabMedium medium{gray3(tau), gray3(albedo), phase};
  for (const double mu0 : {0.9, 0.3})
    for (const double azimuth : {0.0, 2.0, 3.14159}) {
      const double s0 = std::sqrt(1 - mu0 * mu0), s = std::sqrt(1 - mu * mu);
      const std::array<double, 3> from = {s0 * std::cos(azimuth), s0 * std::sin(azimuth), mu0};
      const std::string light =
          fmt::format("LightSource \"distant\" \"point from\" [{} {} {}] \"point to\" [0 0 0]\n",
                      from[0], from[1], from[2]);
      const double cosine = -(s * from[0] + mu * mu0), k = 1 / mu + 1 / mu0;
      const double expected =
          albedo * phase.phase(cosine) / kFourPi / mu / k * -std::expm1(-tau * k);
      expectRadiance(method, slabScene(method, volumesOf(medium, 1e4), light, mu, true),
                     gray3(expected), form,
                     fmt::format("{} mu0 {} azimuth {}", phase.name, mu0, azimuth));
    }
}

std::string phaseNameOf(const testing::TestParamInfo<std::tuple<PhaseCase, Form>>& info) {
  return std::get<PhaseCase>(info.param).name;
}
INSTANTIATE_TEST_SUITE_P(Quick, OneScattering,
                         testing::Combine(testing::ValuesIn(phaseCases()),
                                          testing::Values(Form::Quick)),
                         phaseNameOf);
INSTANTIATE_TEST_SUITE_P(Full, OneScattering,
                         testing::Combine(testing::ValuesIn(phaseCases()),
                                          testing::Values(Form::Full)),
                         phaseNameOf);

}  // namespace
}  // namespace brume::test
