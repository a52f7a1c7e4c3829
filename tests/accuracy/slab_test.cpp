// SPDX-License-Identifier: Apache-2.0
// Slabs under a sky, in a beam and by their own light, against adding-doubling.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "support/slab_cases.h"

namespace brume::test {
namespace {

struct SlabCase {
  std::string name;
  SlabMedium medium;
  std::vector<double> mus;
};

/// A method, a slab, and how precisely it is measured.
struct SlabParam {
  Method method;
  SlabCase slab;
  Form form;
};

void PrintTo(const SlabParam& p, std::ostream* out) { *out << p.slab.name; }
std::string nameOf(const testing::TestParamInfo<SlabParam>& info) {
  return asTestName(info.param.method.name + "_" + info.param.slab.name);
}

std::vector<SlabParam> forAllMethods(const std::vector<SlabCase>& cases, Form form) {
  std::vector<SlabParam> params;
  for (const Method& m : judgedMethods())
    for (const SlabCase& c : cases) params.push_back({m, c, form});
  return params;
}

SlabCase greySlab(double albedo, double g, double tau, const std::vector<double>& mus) {
  return {fmt::format("albedo{}_g{}_tau{}", albedo, g, tau),
          {gray3(tau), gray3(albedo), henyeyGreensteinCase(g)},
          mus};
}

/// DESIGN.md, section 9; adding_doubling_test compares the solver with the printed values.
std::vector<SlabCase> table(const std::vector<double>& mus) {
  return {greySlab(0.9, 0.75, 2, mus), greySlab(1, 0, 1, mus),       greySlab(1, 0, 16, mus),
          greySlab(0.8, 0, 1, mus),    greySlab(0.99, 0.9, 10, mus), greySlab(0.5, -0.5, 2, mus)};
}

/// Thin, thick, forward, backward, nearly conservative.
std::vector<SlabCase> furtherSlabs(const std::vector<double>& mus) {
  return {greySlab(0.97, 0.85, 5, mus), greySlab(0.3, 0.3, 0.5, mus),  greySlab(0.999, 0.5, 4, mus),
          greySlab(0.7, -0.8, 3, mus),  greySlab(1, 0.93, 8, mus),     greySlab(0.95, 0, 0.1, mus),
          greySlab(0.6, 0.6, 30, mus),  greySlab(0.9, -0.3, 1.5, mus), greySlab(0, 0, 1, mus)};
}

std::vector<SlabCase> everyPhase(const std::vector<double>& mus) {
  std::vector<SlabCase> cases;
  for (const PhaseCase& phase : phaseCases())
    cases.push_back({phase.name, {gray3(1.5), gray3(0.9), phase}, mus});
  return cases;
}

constexpr std::array<Build, 5> kBuilds = {Build::Homogeneous, Build::Exponential, Build::Grid,
                                          Build::Split, Build::Overlap};

/// Each channel another medium, in all the ways to build it.
std::vector<SlabCase> chromatic(const std::vector<double>& mus) {
  std::vector<SlabCase> cases;
  for (const Build build : kBuilds)
    cases.push_back({fmt::format("chromatic_{}", nameOf(build)),
                     {{0.5, 1.5, 4}, {0.95, 0.8, 0.5}, henyeyGreensteinCase(0.5), build},
                     mus});
  return cases;
}

std::vector<SlabCase> emitting() {
  std::vector<SlabCase> cases = chromatic({0.7});
  for (SlabCase& c : cases) {
    c.name = "emitting_" + c.name;
    c.medium.emission = 1;
  }
  return cases;
}

std::vector<SlabCase> joined(std::vector<SlabCase> a, const std::vector<SlabCase>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class SlabUnderSky : public testing::TestWithParam<SlabParam> {};

TEST_P(SlabUnderSky, ShowsWhatAddingDoublingSays) {
  const auto& [method, slab, form] = GetParam();
  const auto exact = solve(slab.medium, slab.mus);
  const std::string volumes = volumesOf(slab.medium, method.slabExtent);
  // Of one path in ten thousand a mean to 0.3 % takes 1e9 paths, an hour. What is darker is left
  // out: only the dark side of the absorbing slab of depth 30, and what the slab of albedo 0
  // reflects.
  constexpr double kLeast = 1e-4;
  for (std::size_t i = 0; i < slab.mus.size(); ++i)
    for (const bool lit : {true, false}) {
      const std::array<double, 3>& expected = lit ? exact[i].R : exact[i].T;
      if (*std::ranges::max_element(expected) < kLeast) continue;
      expectRadiance(method, slabScene(method, volumes, sky(), slab.mus[i], lit), expected, form,
                     fmt::format("{} {} at mu {}", slab.name, lit ? "R" : "T", slab.mus[i]));
    }
}

INSTANTIATE_TEST_SUITE_P(Quick, SlabUnderSky,
                         testing::ValuesIn(forAllMethods(
                             joined(joined(table({0.5}), everyPhase({0.5})), chromatic({0.7})),
                             Form::Quick)),
                         nameOf);
INSTANTIATE_TEST_SUITE_P(Full, SlabUnderSky,
                         testing::ValuesIn(forAllMethods(
                             joined(joined(table({1, 0.5, 0.2}), furtherSlabs({1, 0.5, 0.2})),
                                    joined(everyPhase({1, 0.3}), chromatic({0.9, 0.4}))),
                             Form::Full)),
                         nameOf);

class SlabByItsOwnLight : public testing::TestWithParam<SlabParam> {};

TEST_P(SlabByItsOwnLight, ShowsWhatASkyWouldMiss) {
  // With a sky of radiance 1 on both sides every ray would carry 1: the sky's light, R + T, and the
  // medium's own, which is what stays without the sky.
  const auto& [method, slab, form] = GetParam();
  const auto exact = solve(slab.medium, slab.mus);
  for (std::size_t i = 0; i < slab.mus.size(); ++i) {
    std::array<double, 3> expected;
    for (std::size_t c = 0; c < 3; ++c) expected[c] = 1 - exact[i].R[c] - exact[i].T[c];
    expectRadiance(method, {slabView(slab.mus[i], true), volumesOf(slab.medium, method.slabExtent)},
                   expected, form, fmt::format("{} at mu {}", slab.name, slab.mus[i]));
  }
}

INSTANTIATE_TEST_SUITE_P(Quick, SlabByItsOwnLight,
                         testing::ValuesIn(forAllMethods(emitting(), Form::Quick)), nameOf);
INSTANTIATE_TEST_SUITE_P(Full, SlabByItsOwnLight,
                         testing::ValuesIn(forAllMethods(emitting(), Form::Full)), nameOf);

class SlabInParallelLight : public testing::TestWithParam<SlabParam> {};

TEST_P(SlabInParallelLight, ShowsWhatAddingDoublingSays) {
  // Seen along the normal, in light from three of the solver's directions: grazing, slanting and
  // steep.
  const auto& [method, slab, form] = GetParam();
  const SlabMedium& m = slab.medium;
  const auto beams = solveSlabInBeams(m.albedo[0], m.tau[0], averaged(m.phase.phase));
  const std::string volumes = volumesOf(m, method.slabExtent);
  for (const std::size_t node : {beams.size() * 7 / 8, beams.size() / 2, beams.size() / 8}) {
    const SlabInBeam& beam = beams[node];
    const std::string light = fmt::format(
        "LightSource \"distant\" \"point from\" [0 {} {}] \"point to\" [0 0 0] \"color L\" [1 1 "
        "1]\n",
        std::sqrt(1 - beam.mu0 * beam.mu0), beam.mu0);
    for (const bool lit : {true, false})
      expectRadiance(
          method, slabScene(method, volumes, light, 1, lit), gray3(lit ? beam.R : beam.T), form,
          fmt::format("{} {} in light from mu {}", slab.name, lit ? "R" : "T", beam.mu0));
  }
}

std::vector<SlabCase> beamed() {
  return {greySlab(0.9, 0.75, 2, {}), greySlab(1, 0, 1, {}), greySlab(0.8, -0.4, 3, {})};
}
INSTANTIATE_TEST_SUITE_P(Quick, SlabInParallelLight,
                         testing::ValuesIn(forAllMethods(beamed(), Form::Quick)), nameOf);
INSTANTIATE_TEST_SUITE_P(Full, SlabInParallelLight,
                         testing::ValuesIn(forAllMethods(joined(beamed(), everyPhase({})),
                                                         Form::Full)),
                         nameOf);

/// Two media that overlap, each with its own colours and phase function.
class OverlappingMedia : public testing::TestWithParam<SlabParam> {};

TEST_P(OverlappingMedia, EachScattersByItsOwnPhaseFunction) {
  const auto& [method, slab, form] = GetParam();
  // Of every channel's scattering the first medium does `share`; the phase function is the mixture.
  constexpr std::array<double, 3> kShare = {1, 0.4, 0.1};
  const AnglePhase first = henyeyGreensteinOf(0.8), second = henyeyGreensteinOf(-0.5);
  std::array<double, 3> sigma_s1, sigma_s2, sigma_a;
  SlabColours exact[2];
  const std::vector<double> mus = {0.8, 0.3};
  for (std::size_t c = 0; c < 3; ++c) {
    const double sigma_s = slab.medium.tau[c] * slab.medium.albedo[c], w = kShare[c];
    sigma_s1[c] = w * sigma_s;
    sigma_s2[c] = (1 - w) * sigma_s;
    sigma_a[c] = slab.medium.tau[c] - sigma_s;
    const auto solved =
        solveSlab(slab.medium.albedo[c], slab.medium.tau[c],
                  averaged([=](double x) { return w * first(x) + (1 - w) * second(x); }), mus);
    for (std::size_t i = 0; i < 2; ++i) {
      exact[i].R[c] = solved[i].R;
      exact[i].T[c] = solved[i].T;
    }
  }
  const double half = method.slabExtent;
  const std::string box = fmt::format("\"point p0\" [-{0} -{0} 0] \"point p1\" [{0} {0} 1]", half);
  const std::string volumes = fmt::format(
      "Volume \"homogeneous\" \"color sigma_s\" {} \"float g\" .8 {}\n"
      "Volume \"homogeneous\" \"color sigma_s\" {} \"color sigma_a\" {} \"float g\" -.5 {}\n",
      rgbText(sigma_s1), box, rgbText(sigma_s2), rgbText(sigma_a), box);
  for (std::size_t i = 0; i < mus.size(); ++i)
    for (const bool lit : {true, false})
      expectRadiance(method, slabScene(method, volumes, sky(), mus[i], lit),
                     lit ? exact[i].R : exact[i].T, form,
                     fmt::format("{} at mu {}", lit ? "R" : "T", mus[i]));
}

std::vector<SlabCase> overlapping() {
  return {{"twoMedia", {{1, 2, 1.5}, {0.9, 0.95, 0.8}, henyeyGreensteinCase(0)}, {}}};
}
INSTANTIATE_TEST_SUITE_P(Quick, OverlappingMedia,
                         testing::ValuesIn(forAllMethods(overlapping(), Form::Quick)), nameOf);
INSTANTIATE_TEST_SUITE_P(Full, OverlappingMedia,
                         testing::ValuesIn(forAllMethods(overlapping(), Form::Full)), nameOf);

}  // namespace
}  // namespace brume::test
