// SPDX-License-Identifier: Apache-2.0
// The layers of a slab under a sky, seen from both sides and from its middle, against quadrature
// and adding-doubling: which light is counted where, and what is said of the first surface.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/path_component.h"
#include "support/render_text.h"
#include "support/slab_cases.h"

namespace brume::test {
namespace {

constexpr double kMu = 0.6;
constexpr int kPixels = 16, kSamples = 256, kSteps = 1000;

enum class Seat { LitSide, DarkSide, Middle };

/// Of a glowing slab whose source, all scatterings together, would be 1 in equilibrium: sigma_a /
/// sigma_t of it is emitted, and a stretch of the optical depth `deep` seen straight shows this.
double glow(double albedo, double deep) { return (1 - albedo) * -std::expm1(-deep); }

/// Light that was scattered once, isotropically, at the optical depth t: half the albedo times the
/// integral over mu' of the sky's light and of the medium's own, from above and from below.
double onceScattered(double albedo, double tau, double t) {
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double mu = (i + 0.5) / kSteps;
    sum += std::exp(-t / mu) + glow(albedo, t / mu) + glow(albedo, (tau - t) / mu);
  }
  return 0.5 * albedo * sum / kSteps;
}

/// The same as it is seen at mu.
double seenOnceScattered(double albedo, double tau, Seat seat) {
  const double end = seat == Seat::Middle ? 0.5 * tau : tau;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = (i + 0.5) / kSteps * end;
    const double way = seat == Seat::LitSide ? t : end - t;
    sum += onceScattered(albedo, tau, t) * std::exp(-way / kMu) * end / kMu / kSteps;
  }
  return sum;
}

SuiteScene viewFrom(Seat seat, const SlabMedium& medium, const Method& method) {
  SuiteScene scene =
      slabScene(method, volumesOf(medium, method.slabExtent), sky(), kMu, seat == Seat::LitSide);
  const double s = std::sqrt(1 - kMu * kMu);
  if (seat == Seat::Middle) scene.lookAt = fmt::format("0 0 .5  {} 0 {}  0 1 0", -s, 0.5 + kMu);
  return scene;
}

using LayerParam = std::tuple<Build, Seat>;
std::string nameOf(const testing::TestParamInfo<LayerParam>& info) {
  const auto& [build, seat] = info.param;
  const char* kSeats[] = {"lit_side", "dark_side", "middle"};
  return fmt::format("{}_{}", nameOf(build), kSeats[static_cast<int>(seat)]);
}

class LayersOfASlab : public testing::TestWithParam<LayerParam> {};

TEST_P(LayersOfASlab, HoldTheLightThatIsTheirs) {
  const auto& [build, seat] = GetParam();
  // The sky's light and the medium's own together would be 1 with a sky on the other side as well.
  const SlabMedium medium{{0.5, 1.5, 4}, {0.95, 0.8, 0.5}, henyeyGreensteinCase(0), build, 1};
  const Method& method = judgedMethods().front();
  RenderSettings settings;
  settings.layers = settings.variance = true;
  const RenderResult r =
      renderText(sceneText(method, viewFrom(seat, medium, method), kPixels, kSamples), settings);
  EXPECT_EQ(faultsOf(r.stats), 0u);

  const auto exact = solve(medium, {kMu})[0];
  for (std::size_t c = 0; c < 3; ++c) {
    const std::string channel(1, "RGB"[c]);
    const double tau = medium.tau[c];
    const double crossed = std::exp(-(seat == Seat::Middle ? 0.5 : 1) * tau / kMu);
    const auto layer = [&](PathComponent component) {
      return estimateOf(r.image, std::string(componentName(component)) + "." + channel);
    };
    const auto expectNear = [&](const char* what, const Estimate& e, double expected) {
      EXPECT_LT(std::abs(e.mean - expected), 4 * e.standardError + 2e-6)
          << what << ", channel " << channel << ": " << e.mean << " +- " << e.standardError
          << ", expected " << expected;
      EXPECT_LT(e.standardError, 0.02 * expected + 1e-6) << what;
    };
    const double unscattered =
        (1 - medium.albedo[c]) * (1 - crossed) + (seat == Seat::LitSide ? 0 : crossed);
    const double once = seenOnceScattered(medium.albedo[c], tau, seat);
    expectNear("emission", layer(PathComponent::Emission), unscattered);
    expectNear("once", layer(PathComponent::VolumeSingle), once);
    const Estimate whole = estimateOf(r.image, channel);
    if (seat != Seat::Middle) {
      const double all = 1 - (seat == Seat::LitSide ? exact.T[c] : exact.R[c]);
      expectNear("image", whole, all);
      expectNear("more often", layer(PathComponent::VolumeMultiple), all - unscattered - once);
    }
    double sum = 0;
    for (int k = 0; k < kPathComponents; ++k) sum += layer(PathComponent(k)).mean;
    EXPECT_NEAR(sum, whole.mean, 2e-6) << "rounding of float pixels";
    for (const PathComponent none : {PathComponent::SurfaceDirect, PathComponent::SurfaceCaustic,
                                     PathComponent::SurfaceIndirect, PathComponent::VolumeCaustic})
      EXPECT_EQ(layer(none).mean, 0) << componentName(none);

    // All pixels see the same: their scatter is what each says of its own variance. 256 of them
    // know it to 9 %.
    const double scatter = whole.standardError * whole.standardError * kPixels * kPixels;
    EXPECT_NEAR(estimateOf(r.image, "variance." + channel).mean / scatter, 1, 0.4);
    // The middle sees no surface; the dark side neither, as it stands between slab and floor.
    EXPECT_NEAR(estimateOf(r.image, "transmittance." + channel).mean, crossed, 1e-5);
    EXPECT_EQ(estimateOf(r.image, "albedo." + channel).mean, 0) << "the floor is black";
  }
  for (const float samples : r.image.channels.at("samples")) EXPECT_EQ(samples, kSamples);
  for (const float depth : r.image.channels.at("depth.Z"))
    if (seat == Seat::LitSide) {
      // The floor is 40,000 wide: its points are rounded to a thousandth.
      EXPECT_NEAR(depth, (1.001 + 2 * kMu) / kMu, 2e-3);
    } else {
      EXPECT_EQ(depth, kInfinity);
    }
  EXPECT_NEAR(std::abs(estimateOf(r.image, "normal.Z").mean), seat == Seat::LitSide ? 1 : 0, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Quick, LayersOfASlab,
                         testing::Values(std::tuple{Build::Homogeneous, Seat::LitSide},
                                         std::tuple{Build::Homogeneous, Seat::DarkSide},
                                         std::tuple{Build::Homogeneous, Seat::Middle},
                                         std::tuple{Build::Grid, Seat::LitSide},
                                         std::tuple{Build::Grid, Seat::DarkSide}),
                         nameOf);

}  // namespace
}  // namespace brume::test
