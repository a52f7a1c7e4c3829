// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "core/log.h"
#include "core/rng.h"
#include "support/volumes.h"
#include "volumes/phase_functions.h"

namespace brume {
namespace {

struct Case {
  std::string name;
  std::function<std::unique_ptr<PhaseFunction>()> make;
  double g;
  double gTolerance = 2e-6;
};

std::unique_ptr<PhaseFunction> mixture() {
  PhaseParams params;
  params.phase = {"rayleigh", "henyeygreenstein", "schlick", "henyeygreenstein"};
  params.phaseweights = {1.f, 2.f, 3.f, 4.f};
  params.g = {-.9f, .5f, .95f};
  return makePhase(params, {});
}

std::vector<Case> cases() {
  std::vector<Case> all = {
      {"isotropic", makeIsotropicPhase, 0},
      {"rayleigh", makeRayleighPhase, 0},
      {"miehazy", makeMieHazyPhase, 0.4},
      {"miemurky", makeMieMurkyPhase, 16.0 / 34},
      // The mean cosine of Schlick's function is only near g.
      {"mixture", mixture, 0.1 * 0 + 0.2 * -0.9 + 0.3 * 0.5 + 0.4 * 0.95, 0.01}};
  for (const float g : {-.999f, -.9f, -.3f, -1e-4f, 1e-4f, .2f, .75f, .99f, .999f}) {
    all.push_back({"hg" + std::to_string(g), [g] { return makeHenyeyGreensteinPhase(g); }, g});
    // PBRT-v2's fit of k: up to 0.042 off in the mean.
    all.push_back({"schlick" + std::to_string(g), [g] { return makeSchlickPhase(g); }, g, 0.042});
  }
  return all;
}

/// 2 pi Int f(cos) p(cos) dcos, with nodes crowded at both poles: 1 -+ cos = 2 x^4.
double integrateOverSphere(const PhaseFunction& phase, const std::function<double(double)>& f) {
  return test::integrate(
      [&](double x) {
        const double small = x * x * x * x, jacobian = 4 * x * x * x;
        const auto a = static_cast<float>(small), b = static_cast<float>(2 - small);
        const double forward = double{phase.value({a, b})} * f(1 - small);
        const double backward = double{phase.value({b, a})} * f(small - 1);
        return 2 * double{kPi} * jacobian * (forward + backward);
      },
      0, 1, 400);
}

TEST(Phase, IsNormalisedAndHasItsMeanCosine) {
  for (const Case& c : cases()) {
    const auto phase = c.make();
    // Float evaluation of the function leaves about 1e-6.
    EXPECT_NEAR(integrateOverSphere(*phase, [](double) { return 1.0; }), 1, 3e-6) << c.name;
    const double mean = integrateOverSphere(*phase, [](double x) { return x; });
    EXPECT_NEAR(phase->g(), mean, 3e-6) << c.name;
    EXPECT_NEAR(mean, c.g, c.gTolerance) << c.name;
  }
}

TEST(Phase, SamplesAreDistributedAsTheValue) {
  // Chi-square over 64 cells of equal probability of the numerical distribution; 0.001 quantile of
  // 63 degrees of freedom is 103.4, Sidak-corrected for the number of cases about 125.
  constexpr int kCells = 64, kSamples = 64 * 1000;
  for (const Case& c : cases()) {
    const auto phase = c.make();
    // The distribution function at 1 - cos = 2 x^4 or its mirror image, tabulated.
    constexpr int kTable = 4096;
    std::vector<double> x(2 * kTable + 1), cdf(2 * kTable + 1);
    for (int i = 0; i <= 2 * kTable; ++i) x[i] = double(i - kTable) / kTable;
    const auto density = [&](double v) {
      const double a = v * v * v * v, jacobian = 4 * std::abs(v * v * v);
      const auto lo = static_cast<float>(a), hi = static_cast<float>(2 - a);
      const double p = v < 0 ? phase->value({lo, hi}) : phase->value({hi, lo});
      return 2 * double{kPi} * p * jacobian;
    };
    // v < 0: forward, 1 - cos = v^4 grows toward v = -1 (cos = 0); so order by s = -1 - v.
    double sum = 0;
    for (int i = 0; i < 2 * kTable; ++i) {
      sum += test::integrate(density, x[i], x[i + 1], 1);
      cdf[i + 1] = sum;
    }
    std::vector<int> count(kCells, 0);
    Rng rng(17);
    for (int i = 0; i < kSamples; ++i) {
      const float uLobe = rng.uniform();
      const ScatteringAngle angle = phase->sampleAngle(uLobe, rng.uniform());
      ASSERT_NEAR(angle.oneMinusCos + angle.onePlusCos, 2, 2e-6) << c.name;
      const double v = angle.oneMinusCos < angle.onePlusCos
                           ? -std::pow(double{angle.oneMinusCos}, 0.25)
                           : std::pow(double{angle.onePlusCos}, 0.25);
      const double position = std::clamp((v + 1) * kTable, 0.0, 2.0 * kTable - 1e-6);
      const int cell = static_cast<int>(position);
      const double u = cdf[cell] + (position - cell) * (cdf[cell + 1] - cdf[cell]);
      ++count[std::clamp(static_cast<int>(u / sum * kCells), 0, kCells - 1)];
    }
    double chi2 = 0;
    for (const int n : count) chi2 += sqr(n - 1000.0) / 1000.0;
    EXPECT_LT(chi2, 125) << c.name;
  }
}

TEST(Phase, SampledDirectionsCarryTheirValueAndDensity) {
  Rng rng(3);
  for (const Case& c : cases()) {
    const auto phase = c.make();
    for (int i = 0; i < 200; ++i) {
      const Vec3 wo = test::randomDirection(rng);
      const float uLobe = rng.uniform();
      const PhaseSample s = phase->sample(wo, uLobe, rng.uniform2());
      EXPECT_NEAR(length(s.wi), 1, 1e-6);
      EXPECT_EQ(s.pdf, s.value);
      EXPECT_GT(s.value, 0);
      EXPECT_LE(s.value, phase->peak() * (1 + 1e-5f)) << c.name;
      // The direction has the angle that was drawn: float directions leave 1e-7 / 1e-3 of the
      // width of the narrowest lobe, thrice that in the value.
      EXPECT_NEAR(phase->p(wo, s.wi) / s.value, 1, 2e-3) << c.name;
      EXPECT_EQ(phase->p(wo, s.wi), phase->p(s.wi, wo)) << "reciprocity, " << c.name;
    }
  }
}

TEST(Phase, ForwardIsWhereTheLightGoes) {
  const auto phase = makeHenyeyGreensteinPhase(.8f);
  const Vec3 wo(0, 0, 1);
  EXPECT_NEAR(phase->p(wo, -wo), 1.8 / (.2 * .2) / (4 * kPi), 1e-3);
  EXPECT_NEAR(phase->p(wo, wo), .2 / (1.8 * 1.8) / (4 * kPi), 1e-6);
}

TEST(Phase, HenyeyGreensteinAtTheEndsKeepsItsPrecision) {
  for (const double g : {.999, -.999}) {
    const auto phase = makeHenyeyGreensteinPhase(static_cast<float>(g));
    const double gf = static_cast<float>(g);
    for (const double angle : {0.0, 1e-4, 1e-3, 1e-2, 1.0, 3.0}) {
      // Around the peak, which is at angle 0 for g > 0, at pi for g < 0.
      const double turned = g > 0 ? angle : M_PI - angle;
      const Vec3 wo(0, 0, 1);
      const Vec3 wi(Vec3d(std::sin(turned), 0, -std::cos(turned)));
      const double a = std::abs(gf), s = std::sin(0.5 * angle);
      const double expected = (1 - a * a) / (4 * M_PI * std::pow(sqr(1 - a) + 4 * a * s * s, 1.5));
      // Rounding of the direction: 6e-8 rad against a half-width of 1e-3.
      EXPECT_NEAR(phase->p(wo, wi) / expected, 1, 1e-3) << g << ' ' << angle;
    }
  }
}

std::string errorOf(const PhaseParams& params) {
  try {
    makePhase(params, {});
  } catch (const SceneError& e) {
    return e.what();
  }
  return "";
}

TEST(Phase, ParametersAreChecked) {
  PhaseParams p;
  p.phase = {"raleigh"};
  EXPECT_THAT(errorOf(p), testing::HasSubstr("did you mean 'rayleigh'"));
  p.phase = {"isotropic"};
  p.g = {.5f};
  EXPECT_THAT(errorOf(p), testing::HasSubstr("no effect"));
  p.phase = {"schlick", "rayleigh", "henyeygreenstein"};
  p.g = {.5f, .1f, .2f};
  EXPECT_THAT(errorOf(p), testing::HasSubstr("\"g\" has 3 values"));
  p.g = {.5f};
  p.phaseweights = {1.f};
  EXPECT_THAT(errorOf(p), testing::HasSubstr("\"phaseweights\" has 1 values for 3"));
  p.phase = {};
  EXPECT_THAT(errorOf(p), testing::HasSubstr("empty"));
}

}  // namespace
}  // namespace brume
