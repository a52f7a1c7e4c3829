// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "core/triangle_mesh.h"
#include "support/shape_cases.h"

namespace brume {
namespace {

using namespace test;
using testing::HasSubstr;

/// A cylinder of radius 1 and height 2 as nine rational control points times two.
std::vector<Param> cylinder() {
  const float w = std::sqrt(0.5f);
  const std::vector<Vec3> ring{{1, 0, 0},   {1, 1, 0},  {0, 1, 0},  {-1, 1, 0}, {-1, 0, 0},
                               {-1, -1, 0}, {0, -1, 0}, {1, -1, 0}, {1, 0, 0}};
  std::vector<float> Pw;
  for (const float z : {0.f, 2.f})
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const float weight = i % 2 ? w : 1.f;
      Pw.insert(Pw.end(), {ring[i].x * weight, ring[i].y * weight, z * weight, weight});
    }
  return {integers("nu", {9}),
          integers("nv", {2}),
          integers("uorder", {3}),
          integers("vorder", {2}),
          floats("uknots", {0, 0, 0, .25f, .25f, .5f, .5f, .75f, .75f, 1, 1, 1}),
          floats("vknots", {0, 0, 1, 1}),
          floats("Pw", Pw)};
}

TEST(Nurbs, RationalCircleIsACircle) {
  const auto shape = makeShape("nurbs", cylinder());
  const TriangleMesh& mesh = *shape->mesh();
  for (std::size_t i = 0; i < mesh.pointCount(); ++i) {
    const Vec3 p = mesh.pointData()[i];
    EXPECT_NEAR(p.x * p.x + p.y * p.y, 1, 1e-6);
  }
  // Chords within 1/5000 of the size.
  EXPECT_NEAR(shape->area(), 4 * kPiD, 4 * kPiD * 1.5e-3);
  for (std::uint32_t t = 0; t < mesh.triangleCount(); t += 7) {
    const SurfaceInteraction si = mesh.interaction({}, {1, .3f, .3f, t});
    EXPECT_GT(dot(si.n, Vec3(si.p.x, si.p.y, 0)), 0.99f);
    EXPECT_LT(length(si.ns - normalize(Vec3(si.p.x, si.p.y, 0))), 1e-3f);
    EXPECT_NEAR(si.p.z, 2 * si.uv.y, 1e-5);
  }
}

TEST(Nurbs, BezierPatchIsItsPolynomial) {
  // z = x^2 + x y over the unit square, as a biquadratic patch (bilinear in y raised to degree 2).
  std::vector<Vec3> P;
  for (const float y : {0.f, .5f, 1.f})
    for (const float x : {0.f, .5f, 1.f}) P.emplace_back(x, y, (x == 1 ? 1.f : 0.f) + x * y);
  const std::vector<float> knots{0, 0, 0, 1, 1, 1};
  const auto shape =
      makeShape("nurbs", {integers("nu", {3}), integers("nv", {3}), integers("uorder", {3}),
                          integers("vorder", {3}), floats("uknots", knots), floats("vknots", knots),
                          points("P", P), floats("u0", {.25f}), floats("v1", {.5f})});
  const TriangleMesh& mesh = *shape->mesh();
  for (std::size_t i = 0; i < mesh.pointCount(); ++i) {
    const Vec3 p = mesh.pointData()[i];
    EXPECT_NEAR(p.z, p.x * p.x + p.x * p.y, 1e-6);
    EXPECT_GE(p.x, .25f);
    EXPECT_LE(p.y, .5f);
  }
  const SurfaceInteraction si = mesh.interaction({}, {1, 0, 0, 0});
  EXPECT_NEAR(si.uv.x, .25f, 1e-6);
  EXPECT_LT(length(si.ns - normalize(Vec3(-2 * si.p.x - si.p.y, -si.p.x, 1))), 1e-5f);
}

TEST(Nurbs, PolesHaveNormals) {
  // A triangle-like patch: one edge collapsed to a point.
  const std::vector<Vec3> P{{0, 0, 1}, {0, 0, 1}, {-1, 1, 0}, {1, 1, 0}};
  const auto shape =
      makeShape("nurbs", {integers("nu", {2}), integers("nv", {2}), integers("uorder", {2}),
                          integers("vorder", {2}), floats("uknots", {0, 0, 1, 1}),
                          floats("vknots", {0, 0, 1, 1}), points("P", P)});
  for (std::uint32_t t = 0; t < shape->mesh()->triangleCount(); ++t)
    EXPECT_NEAR(std::abs(shape->mesh()->interaction({}, {1, .1f, .1f, t}).ns.x), 0, 1e-3);
}

std::string errorOf(const std::string& replaced, std::optional<Param> by) {
  std::vector<Param> params = cylinder();
  std::erase_if(params, [&](const Param& p) { return p.name == replaced; });
  if (by) params.push_back(*by);
  try {
    makeShape("nurbs", params);
  } catch (const SceneError& e) {
    return e.what();
  }
  return "no error";
}

TEST(Nurbs, BadSurfacesAreRefused) {
  EXPECT_EQ(errorOf("", {}), "no error");
  EXPECT_THAT(errorOf("nu", {}), HasSubstr("needs \"integer nu\""));
  EXPECT_THAT(errorOf("uorder", integers("uorder", {10})), HasSubstr("needs at least 10"));
  EXPECT_THAT(errorOf("vknots", floats("vknots", {0, 0, 1})), HasSubstr("3 values of \"vknots\""));
  EXPECT_THAT(errorOf("vknots", floats("vknots", {0, 1, 0, 1})), HasSubstr("decrease"));
  EXPECT_THAT(errorOf("vknots", floats("vknots", {0, 1, 1, 2})), HasSubstr("no domain"));
  EXPECT_THAT(errorOf("", floats("u0", {2})), HasSubstr("must grow inside"));
  EXPECT_THAT(errorOf("Pw", {}), HasSubstr("either"));
  EXPECT_THAT(errorOf("Pw", floats("Pw", {1, 1, 1, 1})), HasSubstr("1 control points"));
  EXPECT_THAT(errorOf("Pw", floats("Pw", {1, 1, 1})), HasSubstr("multiple of 4"));
  EXPECT_THAT(errorOf("Pw", floats("Pw", std::vector<float>(72, 0))), HasSubstr("weight"));
}

}  // namespace
}  // namespace brume
