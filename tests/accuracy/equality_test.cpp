// SPDX-License-Identifier: Apache-2.0
// Scenes that differ in words only look the same: z-tests with both variances, p > 0.001 for all
// comparisons of a test together (Sidak).
#include <gtest/gtest.h>

#include <cmath>

#include "support/boxes.h"
#include "support/suite.h"

namespace brume::test {
namespace {

struct EqualScenes {
  std::string name;
  std::vector<NamedMedium> scenes;  ///< worlds
  std::string lookAt = kFromOutside;
};
struct EqualParam {
  Method method;
  EqualScenes equal;
  Form form;
};
void PrintTo(const EqualParam& p, std::ostream* out) { *out << p.equal.name; }
std::string nameOf(const testing::TestParamInfo<EqualParam>& info) {
  return asTestName(info.param.method.name + "_" + info.param.equal.name);
}

/// Two-sided probability of a standard normal variable beyond |z|.
double pValue(double z) { return std::erfc(std::abs(z) / std::sqrt(2.0)); }

std::vector<NamedMedium> withLight(const std::string& light, std::vector<NamedMedium> media) {
  for (NamedMedium& m : media) m.text = light + m.text;
  return media;
}

std::vector<EqualScenes> equalScenes() {
  const std::string coefficients =
      "\"color sigma_a\" [.1 .3 1] \"color sigma_s\" [3 2 1] \"float g\" .6";
  const std::string point = "LightSource \"point\" \"point from\" [.4 2 .2] \"color I\" [3 3 3]\n";
  const std::string pointInside =
      "LightSource \"point\" \"point from\" [-.5 .4 .2] \"color I\" [3 3 3]\n";
  const std::string area =
      "AttributeBegin\nAreaLightSource \"area\" \"color L\" [5 5 5]\nTranslate .2 2 .1\n"
      "Rotate 90 1 0 0\nShape \"disk\" \"float radius\" .7\nAttributeEnd\n";
  std::vector<EqualScenes> all;
  all.push_back({"under_a_point_light", withLight(point, equalMedia(coefficients))});
  all.push_back({"around_a_point_light", withLight(pointInside, equalMedia(coefficients))});
  all.push_back({"under_an_area_light", withLight(area, equalMedia(coefficients))});
  all.push_back({"seen_from_inside", withLight(point, equalMedia(coefficients)), kFromInside});
  // A box turned by a transform against one that is written turned.
  all.push_back({"quarter_turn",
                 {{"straight", point + "Volume \"homogeneous\" " + coefficients +
                                   " \"point p0\" [-1 -.5 -.8] \"point p1\" [.3 .7 1]\n"},
                  {"turned", point + "Rotate 90 0 0 1\nVolume \"homogeneous\" " + coefficients +
                                 " \"point p0\" [-.5 -.3 -.8] \"point p1\" [.7 1 1]\n"}}});
  // One light is three of a third each.
  const std::string third = "LightSource \"point\" \"point from\" [.4 2 .2] \"color I\" [1 1 1]\n";
  const std::string medium = equalMedia(coefficients)[0].text;
  all.push_back({"three_lights_for_one",
                 {{"one", point + medium}, {"three", third + third + third + medium}}});
  // A mixture of phase functions is two overlapping media of one phase function each.
  all.push_back(
      {"mixture_is_overlap",
       {{"mixture", point +
                        "Volume \"homogeneous\" \"color sigma_s\" [4 2 1] \"string phase\" "
                        "[\"henyeygreenstein\" \"rayleigh\"] \"float g\" .7 "
                        "\"float phaseweights\" [1 3] " +
                        kUnitBox + "\n"},
        {"overlap", point + "Volume \"homogeneous\" \"color sigma_s\" [1 .5 .25] \"float g\" .7 " +
                        kUnitBox +
                        "\nVolume \"homogeneous\" \"color sigma_s\" [3 1.5 .75] \"string phase\" "
                        "\"rayleigh\" " +
                        kUnitBox + "\n"}}});
  return all;
}

std::vector<EqualParam> forAllMethods(Form form) {
  std::vector<EqualParam> params;
  for (const Method& m : judgedMethods())
    for (const EqualScenes& e : equalScenes()) params.push_back({m, e, form});
  return params;
}

class Equal : public testing::TestWithParam<EqualParam> {};

TEST_P(Equal, LookTheSame) {
  const auto& [method, equal, form] = GetParam();
  Goal goal = form == Form::Full ? Goal{0.002, 1 << 22} : Goal{0.015, 1 << 18};
  std::vector<Measurement> measured;
  for (const NamedMedium& scene : equal.scenes) {
    measured.push_back(measure(method, {equal.lookAt, scene.text}, goal));
    ++goal.seed;  // the z-tests need independent noise
  }
  const double comparisons = 3.0 * static_cast<double>(equal.scenes.size() - 1);
  const double limit = -std::expm1(std::log1p(-0.001) / comparisons);
  for (std::size_t i = 0; i < measured.size(); ++i) {
    EXPECT_EQ(measured[i].faults, 0u) << equal.scenes[i].name;
    for (std::size_t c = 0; c < 3; ++c) {
      const Estimate &a = measured[0].channels[c], &b = measured[i].channels[c];
      EXPECT_LT(b.standardError, 0.03 * b.mean);
      if (i == 0) continue;
      EXPECT_GT(pValue(b.z(a)), limit) << equal.scenes[i].name << ", channel " << c << ": "
                                       << b.mean << " against " << a.mean << ", z " << b.z(a);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Quick, Equal, testing::ValuesIn(forAllMethods(Form::Quick)), nameOf);
INSTANTIATE_TEST_SUITE_P(Full, Equal, testing::ValuesIn(forAllMethods(Form::Full)), nameOf);

}  // namespace
}  // namespace brume::test
