// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <chrono>

#include "core/triangle_mesh.h"
#include "support/shape_cases.h"

namespace brume {
namespace {

using namespace test;
using testing::HasSubstr;

struct Control {
  std::vector<int> indices;
  std::vector<Vec3> P;
};

/// A flat grid of n x n cells, each cut along its diagonal: inner vertices have valence 6.
Control grid(int n) {
  Control c;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) c.P.emplace_back(x, y, 0);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int a = x + y * (n + 1), b = a + 1, d = a + n + 1, e = d + 1;
      c.indices.insert(c.indices.end(), {a, b, e, a, e, d});
    }
  return c;
}

Control octahedron() {
  return {{0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5},
          {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
}

std::unique_ptr<Shape> subdivided(const Control& c, int levels) {
  return makeShape("loopsubdiv", {integers("nlevels", {levels}), integers("indices", c.indices),
                                  points("P", c.P)});
}

TEST(LoopSubdiv, CountsFollowEuler) {
  const auto shape = subdivided(octahedron(), 3);
  EXPECT_EQ(shape->mesh()->triangleCount(), 8u * 64u);
  EXPECT_EQ(shape->mesh()->pointCount(), 8u * 64u / 2u + 2u);  // closed, genus 0
  const auto sheet = subdivided(grid(2), 2);
  EXPECT_EQ(sheet->mesh()->triangleCount(), 8u * 16u);
  EXPECT_EQ(sheet->mesh()->pointCount(), 81u);
}

/// A quadratic function on a regular grid: the limit surface is the box spline, which reproduces
/// linear functions and lifts x^2 by its constant second moment, the same everywhere inside.
TEST(LoopSubdiv, ReproducesPolynomialsInside) {
  for (const int levels : {0, 1, 3}) {
    Control c = grid(8);
    for (Vec3& p : c.P) p.z = 2 * p.x - p.y + 0.5f * p.x * p.x;
    const auto shape = subdivided(c, levels);
    const TriangleMesh& mesh = *shape->mesh();
    double lift = 0;
    int inside = 0;
    for (std::size_t i = 0; i < mesh.pointCount(); ++i) {
      const Vec3 p = mesh.pointData()[i];
      if (p.x < 3 || p.x > 5 || p.y < 3 || p.y > 5) continue;
      const double excess = p.z - (2 * p.x - p.y + 0.5 * p.x * p.x);
      if (inside++ == 0) lift = excess;
      EXPECT_NEAR(excess, lift, 2e-5);
    }
    EXPECT_GT(inside, 8);
    // Second moment of the limit stencil at level 0: 4 of 6 neighbours at distance 1 in x, each of
    // weight 1/12: half of 4/12.
    EXPECT_NEAR(lift, 1.0 / 6, 1e-5);
    // The normal is that of the parabola, and by PBRT-v2's masks on the far side of the winding.
    for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) {
      const SurfaceInteraction si = mesh.interaction({}, {1, 0, 0, t});
      if (si.p.x < 3 || si.p.x > 5 || si.p.y < 3 || si.p.y > 5) continue;
      const Vec3 n = normalize(Vec3(-2 - si.p.x, 1, 1));
      EXPECT_LT(length(si.ns + n), 1e-4);
      EXPECT_GT(si.n.z, 0);
    }
  }
}

/// Vertices pushed to the limit do not move when the mesh is refined first: limit masks and
/// subdivision rules agree, at extraordinary vertices and boundaries too.
TEST(LoopSubdiv, LimitPointsDoNotDependOnTheLevel) {
  Control open = grid(3);
  for (Vec3& p : open.P) p.z = std::sin(p.x) * std::cos(2 * p.y);
  for (const Control& c : {octahedron(), open}) {
    const auto coarse = subdivided(c, 0), fine = subdivided(c, 3);
    for (std::size_t i = 0; i < c.P.size(); ++i)
      EXPECT_LT(distance(coarse->mesh()->pointData()[i], fine->mesh()->pointData()[i]), 2e-6f);
  }
}

/// The same for the normals, against the faces of a fine mesh around the vertex.
TEST(LoopSubdiv, LimitNormalsAreThoseOfTheFineSurface) {
  Control open = grid(3);
  for (Vec3& p : open.P) p.z = 0.3f * std::sin(p.x) * std::cos(2 * p.y);
  for (const Control& c : {octahedron(), open}) {
    const auto coarse = subdivided(c, 0), fine = subdivided(c, 6);
    const TriangleMesh& mesh = *coarse->mesh();
    for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) {
      const SurfaceInteraction si = mesh.interaction({}, {1, 0, 0, t});  // at its first corner
      const int vertex = mesh.indexData()[3 * t];
      Vec3d sum(0);
      const TriangleMesh& f = *fine->mesh();
      for (std::uint32_t k = 0; k < f.triangleCount(); ++k)
        for (int corner = 0; corner < 3; ++corner)
          if (f.indexData()[3 * k + corner] == vertex)
            sum += Vec3d(f.interaction({}, {1, .3f, .3f, k}).n);
      // A fine face is 1/64 of a coarse one: curvature 1 turns its normal by some hundredths.
      EXPECT_LT(length(normalize(sum) + Vec3d(si.ns)), 0.06);
    }
  }
}

TEST(LoopSubdiv, UnusualMeshesComeToAnEnd) {
  // A fan of three faces on one edge, a Moebius-like pair, a bow tie, a double face, an unused
  // point.
  const std::vector<Vec3> P{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {5, 5, 5}};
  for (const std::vector<int>& indices : {std::vector<int>{0, 1, 2, 0, 1, 3, 0, 1, 4},
                                          {0, 1, 2, 0, 1, 3},
                                          {0, 1, 2, 0, 3, 4},
                                          {0, 1, 2, 0, 2, 1},
                                          {0, 0, 0},
                                          {0, 0, 1},
                                          {0, 1, 2, 0, 1, 2}}) {
    const auto shape = subdivided({indices, P}, 3);
    EXPECT_EQ(shape->mesh()->triangleCount(), indices.size() / 3 * 64);
    for (std::size_t i = 0; i < shape->mesh()->pointCount(); ++i)
      EXPECT_TRUE(isFinite(shape->mesh()->pointData()[i]));
    EXPECT_LE(shape->bounds().hi.x, 1.001f);  // the unused point does not count
  }
}

std::string errorOf(std::vector<Param> params) {
  try {
    makeShape("loopsubdiv", std::move(params));
  } catch (const SceneError& e) {
    return e.what();
  }
  return "no error";
}

TEST(LoopSubdiv, BadMeshesAreRefused) {
  const Control c = octahedron();
  const Param P = points("P", c.P), I = integers("indices", c.indices);
  EXPECT_THAT(errorOf({P}), HasSubstr("needs \"integer indices\""));
  EXPECT_THAT(errorOf({I}), HasSubstr("needs \"point P\""));
  EXPECT_THAT(errorOf({P, integers("indices", {0, 1, 6})}), HasSubstr("index 6 is out of range"));
  EXPECT_THAT(errorOf({P, integers("indices", {0, 1})}), HasSubstr("multiple of 3"));
  EXPECT_THAT(errorOf({P, I, integers("nlevels", {-1})}), HasSubstr("nlevels"));
  EXPECT_THAT(errorOf({P, I, integers("nlevels", {14})}), HasSubstr("GB"));
  EXPECT_THAT(errorOf({P, I, integers("nlevels", {2000000000})}), HasSubstr("triangles"));
  EXPECT_THAT(errorOf({P, I, string("scheme", "catmull")}), HasSubstr("scheme"));
}

}  // namespace
}  // namespace brume
