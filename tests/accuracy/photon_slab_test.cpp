// SPDX-License-Identifier: Apache-2.0
// Slabs under a sky by photon methods, against adding-doubling: all scattered light is left to the
// photons. The camera looks along the normal, where nothing varies across the beams: disc kernels
// of any radius have no bias, as long as they stay away from the sides of the slab; balls have
// O(r^2).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/render_text.h"
#include "support/slab_cases.h"

namespace brume::test {
namespace {

constexpr double kHalf = 8;     // half-width of the slab, in its thickness
constexpr double kView = 4;     // half-width of what the camera sees of it, away from the sides
constexpr double kRadius = .5;  // of the beams
constexpr double kBallRadius = .1, kBallBias = 0.005;

struct PhotonSlab {
  std::string method;
  double albedo, g, tau;
};
void PrintTo(const PhotonSlab& p, std::ostream* out) { *out << p.method << p.albedo; }
std::string nameOf(const testing::TestParamInfo<PhotonSlab>& info) {
  const PhotonSlab& p = info.param;
  return asTestName(fmt::format("{}_albedo{}_g{}_tau{}", p.method, p.albedo, p.g, p.tau));
}

/// From the lit side, or from the dark one, where a black bowl hides the sky below.
std::string slabText(const PhotonSlab& p, bool isLit) {
  const std::string photons =
      p.method == "pvpm"
          ? "\"integer passes\" 2 \"integer photonsperpass\" 200000 \"float alpha\" 1"
      : p.method == "vpm" ? "\"integer photons\" 250000"  // small balls hold few of them
                          : "\"integer photons\" 120000";
  const SlabMedium medium{gray3(p.tau), gray3(p.albedo), henyeyGreensteinCase(p.g)};
  return fmt::format(
      "LookAt 0 0 {0}  0 0 0  0 1 0\n"
      "Camera \"orthographic\" \"float screenwindow\" [-{1} {1} -{1} {1}]\n"
      "Film \"image\" \"integer xresolution\" 24 \"integer yresolution\" 24\n"
      "Sampler \"random\" \"integer pixelsamples\" 4\n"
      "GlobalIntegrator \"{2}\" {3} \"float radius\" {4} \"bool directvolume\" "
      "\"false\"\nWorldBegin\n"
      "{5}{6}Material \"matte\" \"color Kd\" [0 0 0]\n"
      "Shape \"sphere\" \"float radius\" 16 \"float zmin\" -16 \"float zmax\" -.001\nWorldEnd\n",
      isLit ? 9 : -8, kView, p.method, photons, p.method == "vpm" ? kBallRadius : kRadius, sky(),
      volumesOf(medium, kHalf));
}

class PhotonSlabUnderSky : public testing::TestWithParam<PhotonSlab> {};

TEST_P(PhotonSlabUnderSky, ShowsWhatAddingDoublingSays) {
  const PhotonSlab& p = GetParam();
  const auto exact = solve({gray3(p.tau), gray3(p.albedo), henyeyGreensteinCase(p.g)}, {1}).front();
  constexpr int kSeeds = 6;
  for (const bool isLit : {true, false}) {
    double sum = 0, squares = 0;
    for (int seed = 0; seed < kSeeds; ++seed) {
      RenderSettings settings;
      settings.seed = static_cast<std::uint64_t>(seed);
      const double mean = double{meanOf(renderText(slabText(p, isLit), settings).image).g};
      sum += mean;
      squares += mean * mean;
    }
    const double mean = sum / kSeeds, expected = isLit ? exact.R[1] : exact.T[1],
                 error = std::sqrt((squares / kSeeds - mean * mean) / (kSeeds - 1));
    // 5 standard errors of 6 renders: by chance once in 250.
    const double bias = p.method == "vpm" ? kBallBias : 0;
    EXPECT_LT(std::abs(mean - expected), 5 * error + bias * expected)
        << (isLit ? "R " : "T ") << mean << " +- " << error << " against " << expected;
    // 1 %, or 0.004 where little light is seen.
    EXPECT_LT(error, 0.01 * std::max(expected, 0.4)) << (isLit ? "R" : "T");
  }
}

std::vector<PhotonSlab> slabs() {
  std::vector<PhotonSlab> all;
  for (const char* method : {"bre", "pvpm"}) {
    all.push_back({method, 0.8, 0, 1});
    all.push_back({method, 0.9, 0.75, 2});
    all.push_back({method, 1, 0, 1});
    all.push_back({method, 0.5, -0.5, 2});
  }
  all.push_back({"vpm", 0.9, 0.75, 2});
  all.push_back({"vpm", 1, 0, 1});
  return all;
}
INSTANTIATE_TEST_SUITE_P(Quick, PhotonSlabUnderSky, testing::ValuesIn(slabs()), nameOf);

}  // namespace
}  // namespace brume::test
