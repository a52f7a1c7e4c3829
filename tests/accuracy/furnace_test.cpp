// SPDX-License-Identifier: Apache-2.0
// Furnaces: under radiance 1 from everywhere, media that give back what they take show 1 in every
// direction, whatever they are made of. An albedo, a phase function or a weight that is wrong
// anywhere shows.
#include <gtest/gtest.h>

#include "support/boxes.h"
#include "support/slab_cases.h"

namespace brume::test {
namespace {

struct FurnaceCase {
  std::string name, world;
};
struct FurnaceParam {
  Method method;
  FurnaceCase furnace;
  Form form;
};
void PrintTo(const FurnaceParam& p, std::ostream* out) { *out << p.furnace.name; }
std::string nameOf(const testing::TestParamInfo<FurnaceParam>& info) {
  return asTestName(info.param.method.name + "_" + info.param.furnace.name);
}

std::vector<FurnaceCase> furnaces(bool all) {
  std::vector<FurnaceCase> cases;
  // Scattering alone.
  for (const NamedMedium& m : equalMedia("\"color sigma_s\" [.5 2 8] \"float g\" .4"))
    cases.push_back({"white_" + m.name, m.text});
  for (const double g : {-0.9, 0.9})
    cases.push_back(
        {fmt::format("white_g{}", g),
         equalMedia(fmt::format("\"color sigma_s\" [3 3 3] \"float g\" {}", g))[0].text});
  cases.push_back({"white_uneven", unevenGrid("\"color sigma_s\" [1 3 6] \"float g\" .6")});
  cases.push_back({"white_cloud",
                   "Volume \"cloud\" \"color sigma_s\" [2 4 8] \"float g\" .5 "
                   "\"point p0\" [-1 -1 -1] \"point p1\" [1 1 1]\n"});
  // Absorbing, emitting what it absorbs, and scattering.
  const std::string balanced =
      "\"color sigma_s\" [2 1 .5] \"color sigma_a\" [.2 1 4] \"color Le\" [.2 1 4] \"float g\" .5";
  for (const NamedMedium& m : equalMedia(balanced)) cases.push_back({"balanced_" + m.name, m.text});
  cases.push_back({"balanced_uneven", unevenGrid(balanced)});
  // Two media that overlap in part, turned and stretched.
  const std::string two =
      "AttributeBegin\nRotate 30 1 2 3\nScale 1 .5 1.5\n" +
      unevenGrid("\"color sigma_s\" [1 2 3] \"float g\" .8") + "AttributeEnd\n" +
      "Volume \"homogeneous\" \"color sigma_s\" [2 .1 1] \"float g\" -.6 \"color sigma_a\" [.1 .2 "
      ".3] "
      "\"color Le\" [.1 .2 .3] \"point p0\" [-.3 -2 -2] \"point p1\" [.8 2 .5]\n";
  cases.push_back({"overlap", two});
  // White surfaces: one in the medium, one that closes it from below, in its boundary.
  const std::string ball =
      "Material \"matte\" \"color Kd\" [1 1 1]\nShape \"sphere\" \"float radius\" .6\n";
  cases.push_back({"around_a_ball", equalMedia(balanced)[0].text + ball});
  cases.push_back({"on_a_floor", unevenGrid(balanced) + floorAt(-1, 1, 1)});
  cases.push_back({"bare_floor", floorAt(-1, 1, 1)});
  // Walls that emit what they absorb shut the sky out.
  cases.push_back({"in_an_emitting_box", unevenGrid("\"color sigma_s\" [1 2 4]") + emittingBox()});
  if (all)
    for (const PhaseCase& phase : phaseCases())
      cases.push_back(
          {"phase_" + phase.name, equalMedia("\"color sigma_s\" [1 3 5] " + phase.params)[0].text});
  return cases;
}

std::vector<FurnaceParam> forAllMethods(Form form) {
  std::vector<FurnaceParam> params;
  for (const Method& m : judgedMethods())
    for (const FurnaceCase& c : furnaces(form == Form::Full)) params.push_back({m, c, form});
  return params;
}

class Furnace : public testing::TestWithParam<FurnaceParam> {};

TEST_P(Furnace, ShowsOne) {
  const auto& [method, furnace, form] = GetParam();
  for (const std::string& lookAt : {kFromOutside, kFromInside}) {
    // From inside the ball or outside of the walls there is nothing to see.
    if (lookAt == kFromInside && furnace.name == "around_a_ball") continue;
    if (lookAt == kFromOutside && furnace.name == "in_an_emitting_box") continue;
    expectRadiance(method, {lookAt, sky() + furnace.world}, gray3(1), form, furnace.name);
  }
}

INSTANTIATE_TEST_SUITE_P(Quick, Furnace, testing::ValuesIn(forAllMethods(Form::Quick)), nameOf);
INSTANTIATE_TEST_SUITE_P(Full, Furnace, testing::ValuesIn(forAllMethods(Form::Full)), nameOf);

}  // namespace
}  // namespace brume::test
