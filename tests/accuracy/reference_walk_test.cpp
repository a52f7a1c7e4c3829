// SPDX-License-Identifier: Apache-2.0
// Boxes of media around point lights, all scatterings, against an independent random walk.
#include <gtest/gtest.h>

#include "support/boxes.h"
#include "support/reference_walk.h"
#include "support/suite.h"

namespace brume::test {
namespace {

struct WalkCase {
  std::string name;
  ReferenceScene scene;
};
struct WalkParam {
  Method method;
  WalkCase walk;
  Form form;
};
void PrintTo(const WalkParam& p, std::ostream* out) { *out << p.walk.name; }
std::string nameOf(const testing::TestParamInfo<WalkParam>& info) {
  return asTestName(info.param.method.name + "_" + info.param.walk.name);
}

std::vector<WalkCase> walkCases() {
  const ReferenceMedium red{{-1, -1, -1}, {1, 1, 0.3}, {0.1, 0.2, 0.4}, {2, 1, 0.3}, 0.7};
  const ReferenceMedium blue{{-0.5, -2, -0.6}, {2, 0.5, 1}, {0.3, 0.1, 0}, {0.2, 0.8, 2.5}, -0.4};
  ReferenceMedium uneven{{-1, -1, -1}, {1, 1, 1}, {0.3, 0.3, 0.3}, {1, 2, 4}, 0.5, 2.5};
  uneven.density = [](const Point& p) { return unevenDensity(p[0], p[1], p[2]); };
  const ReferenceMedium below{{-1, -1, -1}, {1, -0.2, 1}, {0.1, 0.2, 0.3}, {2, 3, 1}, 0.3};
  const ReferenceMedium above{{-1, 0.2, -1}, {1, 1.5, 1}, {0.1, 0.1, 0.1}, {1, 2, 3}, -0.2};
  return {
      {"overlapping_boxes", {{red, blue}, {0.4, 3, 0.6}, {9, 9, 9}, {4, 3, 5}, {0.1, -0.2, 0}}},
      {"uneven_grid", {{uneven}, {-2, 1.5, 1}, {9, 9, 9}, {4, 3, 5}, {0.1, 0.2, 0.3}}},
      {"light_between_two_boxes",
       {{below, above}, {0.1, 0, -0.2}, {2, 2, 2}, {0.3, -0.6, 0.2}, {-1, -0.5, -2}}},
  };
}

std::string textOf(const ReferenceScene& s) {
  std::string text = fmt::format("LightSource \"point\" \"point from\" [{} {} {}] \"color I\" {}\n",
                                 s.light[0], s.light[1], s.light[2], rgbText(s.I));
  for (const ReferenceMedium& m : s.media) {
    const std::string coefficients =
        fmt::format("\"color sigma_a\" {} \"color sigma_s\" {} \"float g\" {}", rgbText(m.sigma_a),
                    rgbText(m.sigma_s), m.g);
    text += m.maxDensity == 1
                ? fmt::format(
                      "Volume \"homogeneous\" {} \"point p0\" [{} {} {}] \"point p1\" "
                      "[{} {} {}]\n",
                      coefficients, m.lo[0], m.lo[1], m.lo[2], m.hi[0], m.hi[1], m.hi[2])
                : unevenGrid(coefficients);
  }
  return text;
}

class ReferenceWalk : public testing::TestWithParam<WalkParam> {};

TEST_P(ReferenceWalk, Agrees) {
  const auto& [method, walk, form] = GetParam();
  const ReferenceScene& s = walk.scene;
  const double precision = form == Form::Full ? 0.002 : 0.01;
  const std::string lookAt = fmt::format("{} {} {}  {} {} {}  0 1 0", s.camera[0], s.camera[1],
                                         s.camera[2], s.target[0], s.target[1], s.target[2]);
  const Measurement m = measure(method, {lookAt, textOf(s)}, {precision});
  EXPECT_EQ(m.faults, 0u);
  for (std::size_t c = 0; c < 3; ++c) {
    const Estimate reference =
        referenceRadiance(s, c, form == Form::Full ? 3'000'000 : 150'000, 7 + c);
    const Estimate& e = m.channels[c];
    // Both have noise; |z| < 4 fails by chance once in 16,000.
    EXPECT_LT(std::abs(e.z(reference)), 4)
        << "channel " << c << ": " << e.mean << " +- " << e.standardError << " against "
        << reference.mean << " +- " << reference.standardError;
    EXPECT_LT(e.standardError, 1.1 * precision * e.mean);
    EXPECT_LT(reference.standardError, 1.5 * precision * e.mean);
  }
}

std::vector<WalkParam> forAllMethods(Form form) {
  std::vector<WalkParam> params;
  for (const Method& m : judgedMethods())
    for (const WalkCase& w : walkCases()) params.push_back({m, w, form});
  return params;
}
INSTANTIATE_TEST_SUITE_P(Quick, ReferenceWalk, testing::ValuesIn(forAllMethods(Form::Quick)),
                         nameOf);
INSTANTIATE_TEST_SUITE_P(Full, ReferenceWalk, testing::ValuesIn(forAllMethods(Form::Full)), nameOf);

}  // namespace
}  // namespace brume::test
