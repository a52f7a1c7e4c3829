// SPDX-License-Identifier: Apache-2.0
// TriangleMesh itself, and the plugins trianglemesh and heightfield.
#include "core/triangle_mesh.h"

#include <gmock/gmock.h>

#include "support/shape_cases.h"

namespace brume {
namespace {

using namespace test;
using testing::HasSubstr;

MeshData randomMesh(Rng& rng, int triangles, bool withNormals, bool withUvs) {
  MeshData data;
  for (int i = 0; i < 3 * triangles; ++i) {
    data.indices.push_back(i);
    data.points.emplace_back(rng.uniform(), rng.uniform(), rng.uniform());
    if (withNormals) data.normals.emplace_back(rng.uniform(), rng.uniform(), 1.f);
    if (withUvs) data.uvs.insert(data.uvs.end(), {rng.uniform(), rng.uniform()});
  }
  return data;
}

TEST(TriangleMesh, PointsAreWithinTheirErrorOfTheExactOnes) {
  for (const TransformCase& t : transformCases()) {
    SCOPED_TRACE(t.label);
    Rng rng(1);
    Shape::FactoryContext context;
    context.objectToShape = t.transform;
    const TriangleMesh mesh(randomMesh(rng, 50, false, false), context);
    for (std::uint32_t i = 0; i < mesh.triangleCount(); ++i) {
      const Vec3* p = mesh.pointData() + 3 * i;
      const float u = rng.uniform(), v = (1 - u) * rng.uniform();
      const SurfaceInteraction si = mesh.interaction({}, {1, u, v, i});
      const Vec3d exact = Vec3d(p[0]) * (1 - double{u} - double{v}) + Vec3d(p[1]) * double{u} +
                          Vec3d(p[2]) * double{v};
      for (int k = 0; k < 3; ++k) EXPECT_LE(std::abs(si.p[k] - exact[k]), si.pError[k]);
      EXPECT_LT(length(si.pError), 2e-6f * (length(p[0]) + length(p[1]) + length(p[2])));
    }
  }
}

TEST(TriangleMesh, DerivativesAgreeWithDifferences) {
  Rng rng(2);
  Shape::FactoryContext context;
  context.objectToShape = Transform::scale(2, -1, 3) * Transform::rotate(20, {1, 2, 3});
  const TriangleMesh mesh(randomMesh(rng, 40, true, true), context);
  for (std::uint32_t i = 0; i < mesh.triangleCount(); ++i) {
    const auto at = [&](float u, float v) { return mesh.interaction({}, {1, u, v, i}); };
    const float h = 0.01f;
    const SurfaceInteraction c = at(.3f, .3f), a = at(.3f + h, .3f), b = at(.3f, .3f + h);
    // Moving the barycentrics moves uv, and through the derivatives p and the normal.
    for (const SurfaceInteraction& moved : {a, b}) {
      const Vec2 d = moved.uv - c.uv;
      const Vec3 dp = c.geometry.dpdu * d.x + c.geometry.dpdv * d.y;
      const float scale =
          length(c.geometry.dpdu) * std::abs(d.x) + length(c.geometry.dpdv) * std::abs(d.y);
      EXPECT_LT(length(moved.p - c.p - dp), 1e-3f * scale + 1e-5f);
      const Vec3 dn = c.shading.dndu * d.x + c.shading.dndv * d.y;
      EXPECT_LT(length(moved.ns - c.ns - dn), 0.05f * length(moved.ns - c.ns) + 1e-4f);
    }
    EXPECT_NEAR(length(c.n), 1, 1e-5);
    EXPECT_NEAR(length(c.ns), 1, 1e-5);
    EXPECT_NEAR(dot(c.shading.dpdu, c.ns), 0, 1e-5);
    EXPECT_NEAR(dot(c.shading.dpdv, c.ns), 0, 1e-5);
  }
}

/// The normals of the same triangle under all four combinations of mirroring and reversal.
TEST(TriangleMesh, NormalsFlipAsInPbrt) {
  for (const bool mirrors : {false, true})
    for (const bool reverses : {false, true}) {
      MeshData data;
      data.indices = {0, 1, 2};
      data.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
      data.normals.assign(3, Vec3(0, 0, 1));
      data.uvs = {0, 0, 0, 1, 1, 0};  // mirrored uv do not turn the normal
      Shape::FactoryContext context;
      context.reverseOrientation = reverses;
      if (mirrors) context.objectToShape = Transform::scale(-1, 1, 1);
      const TriangleMesh mesh(data, context);
      const SurfaceInteraction si = mesh.interaction({}, {1, .2f, .2f, 0});
      // A mirrored face keeps its geometric normal in space; reversal turns it.
      EXPECT_EQ(si.n.z, reverses ? -1 : 1);
      EXPECT_EQ(mesh.sampleArea({.1f, .1f}).n, si.n);
      // The shading normal is transformed, then flipped like the shape.
      EXPECT_EQ(si.ns.z, mirrors != reverses ? -1 : 1);
    }
}

TEST(TriangleMesh, TangentsOfShadingAreThoseOfPbrt) {
  MeshData data;
  data.indices = {0, 1, 2};
  data.points = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}};
  data.normals.assign(3, Vec3(0, 0, 1));
  const SurfaceInteraction si = TriangleMesh(data, {}).interaction({}, {1, .2f, .2f, 0});
  EXPECT_EQ(si.geometry.dpdu, Vec3(2, 0, 0));
  EXPECT_EQ(si.geometry.dpdv, Vec3(0, 2, 0));
  EXPECT_EQ(si.shading.dpdu, Vec3(-1, 0, 0));
  EXPECT_EQ(si.shading.dpdv, Vec3(0, -1, 0));
}

/// The triangle of three own vertices that a point lies on: the parts into which the point cuts it
/// have the area of the whole.
std::size_t triangleOf(const TriangleMesh& mesh, const Vec3& p) {
  std::size_t best = 0;
  double least = 1e300;
  for (std::size_t i = 0; i < mesh.triangleCount(); ++i) {
    const Vec3* v = mesh.pointData() + 3 * i;
    const auto area = [](const Vec3& a, const Vec3& b, const Vec3& c) {
      return length(cross(Vec3d(b) - Vec3d(a), Vec3d(c) - Vec3d(a)));
    };
    const double whole = area(v[0], v[1], v[2]);
    const double excess = area(p, v[0], v[1]) + area(p, v[1], v[2]) + area(p, v[2], v[0]) - whole;
    if (whole > 0 && excess / whole < least) {
      least = excess / whole;
      best = i;
    }
  }
  return best;
}

TEST(TriangleMesh, SamplesAreUniformByArea) {
  Rng rng(3);
  Shape::FactoryContext context;
  context.objectToShape = Transform::scale(-1, 2, 3);
  MeshData data = randomMesh(rng, 12, false, false);
  data.points[5] = data.points[4];  // one without area
  const TriangleMesh mesh(data, context);
  constexpr int kSamples = 20000;
  std::vector<double> counts(12), areas(12);
  Vec3d centroid(0), expectedCentroid(0);
  for (int i = 0; i < kSamples; ++i) {
    const ShapeSample s = mesh.sampleArea(rng.uniform2());
    counts[triangleOf(mesh, s.p)] += 1;
    centroid += Vec3d(s.p) / double{kSamples};
    ASSERT_FLOAT_EQ(s.pdf * mesh.area(), 1);
  }
  double chi2 = 0;
  for (std::size_t i = 0; i < 12; ++i) {
    const Vec3* p = mesh.pointData() + 3 * i;
    areas[i] = 0.5 * length(cross(Vec3d(p[1] - p[0]), Vec3d(p[2] - p[0])));
    expectedCentroid += Vec3d(p[0] + p[1] + p[2]) * (areas[i] / 3 / mesh.area());
    const double expected = kSamples * areas[i] / mesh.area();
    if (expected > 0) chi2 += (counts[i] - expected) * (counts[i] - expected) / expected;
  }
  EXPECT_EQ(counts[1], 0);
  EXPECT_LT(chi2, 35);                                   // 10 degrees of freedom: p = 1e-4
  EXPECT_LT(length(centroid - expectedCentroid), 0.03);  // 4 sigma of the mean, sigma about 1
}

TEST(TriangleMesh, DegenerateTrianglesGiveFiniteInteractions) {
  MeshData data;
  data.indices = {0, 0, 0, 0, 1, 1, 0, 1, 2};
  data.points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  data.normals.assign(3, Vec3(0));
  const TriangleMesh mesh(data, {});
  EXPECT_EQ(mesh.area(), 0);
  EXPECT_FALSE(mesh.canSample());
  for (std::uint32_t i = 0; i < 3; ++i) {
    const SurfaceInteraction si = mesh.interaction({{0, 0, 1}, {0, 0, -1}}, {1, .3f, .3f, i});
    for (const Vec3& v : {si.p, si.pError, si.n, si.ns, si.geometry.dpdu, si.geometry.dpdv,
                          si.shading.dpdu, si.shading.dpdv, si.shading.dndu, si.shading.dndv})
      EXPECT_TRUE(isFinite(v));
  }
}

TEST(TriangleMesh, KeepsPrecisionWhenTheSceneIsShiftedFarAway) {
  // Object at 1e5, shift by -1e5 + 0.125: the sum must be exact.
  MeshData data;
  data.indices = {0, 1, 2};
  data.points = {{100000, 0, 0}, {100001, 0, 0}, {100000, 1, 0}};
  Shape::FactoryContext context;
  context.objectToShape = Transform::translate({-100000.1, 0, 0});
  const TriangleMesh mesh(data, context);
  EXPECT_FLOAT_EQ(mesh.pointData()[0].x, -0.1f);
}

std::string errorOf(const char* plugin, std::vector<Param> params, const Transform& t = {}) {
  try {
    makeShape(plugin, std::move(params), t);
  } catch (const SceneError& e) {
    return e.what();
  }
  return "no error";
}

TEST(TriangleMesh, BadMeshesAreRefused) {
  const Param p = points("P", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const Param i = integers("indices", {0, 1, 2});
  EXPECT_EQ(errorOf("trianglemesh", {p, i}), "no error");
  EXPECT_THAT(errorOf("trianglemesh", {p}), HasSubstr("needs \"integer indices\""));
  EXPECT_THAT(errorOf("trianglemesh", {i}), HasSubstr("needs \"point P\""));
  EXPECT_THAT(errorOf("trianglemesh", {p, integers("indices", {0, 1, 3})}),
              HasSubstr("index 3 (number 2) is out of range"));
  EXPECT_THAT(errorOf("trianglemesh", {p, integers("indices", {0, -1, 2})}), HasSubstr("-1"));
  EXPECT_THAT(errorOf("trianglemesh", {p, integers("indices", {0, 1, 2, 0})}),
              HasSubstr("multiple of 3"));
  EXPECT_THAT(errorOf("trianglemesh", {p, i, normals("N", {{0, 0, 1}})}),
              HasSubstr("1 normals for 3 points"));
  EXPECT_THAT(errorOf("trianglemesh", {p, i, vectors("S", {{0, 0, 1}})}),
              HasSubstr("1 tangents for 3 points"));
  EXPECT_THAT(errorOf("trianglemesh", {p, i, floats("uv", {0, 0, 1})}), HasSubstr("6 are needed"));
  EXPECT_THAT(errorOf("trianglemesh", {p, i}, Transform::scale(1e20, 1, 1)),
              HasSubstr("point number 1"));
}

TEST(TriangleMesh, MoreUvsThanNeededWarn) {
  Log log(Log::Options{Verbosity::Normal, false, true});
  const auto mesh =
      make<Shape>("trianglemesh",
                  {points("P", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), integers("indices", {0, 1, 2}),
                   floats("st", {0, 0, 1, 0, 1, 1, 9})},
                  {}, nullptr, log);
  EXPECT_EQ(log.warningCount(), 1);
}

TEST(TriangleMesh, DegenerateUvsAreDiscardedWhenAsked) {
  MeshData data;
  data.indices = {0, 1, 2};
  data.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  data.normals.assign(3, Vec3(0, 0, 1));
  data.uvs = {.5f, .5f, .5f, .5f, .5f, 1};
  EXPECT_EQ(TriangleMesh(data, {}).interaction({}, {1, 1, 0, 0}).uv, Vec2(.5f, .5f));
  data.discardDegenerateUvs = true;
  EXPECT_EQ(TriangleMesh(data, {}).interaction({}, {1, 1, 0, 0}).uv, Vec2(1, 0));
}

TEST(Heightfield, IsTheGridOverTheUnitSquare) {
  std::vector<float> heights;
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x) heights.push_back(float(x + 10 * y));
  const auto shape =
      makeShape("heightfield", {integers("nu", {4}), integers("nv", {3}), floats("Pz", heights)});
  const TriangleMesh& mesh = *shape->mesh();
  EXPECT_EQ(mesh.triangleCount(), 12u);
  EXPECT_EQ(mesh.pointCount(), 12u);
  EXPECT_EQ(mesh.pointData()[5], Vec3(1.f / 3.f, 0.5f, 11));
  // Over each triangle p.xy is uv, and faces look up.
  for (std::uint32_t i = 0; i < 12; ++i) {
    const SurfaceInteraction si = mesh.interaction({}, {1, .25f, .5f, i});
    EXPECT_NEAR(si.p.x, si.uv.x, 1e-6);
    EXPECT_NEAR(si.p.y, si.uv.y, 1e-6);
    EXPECT_NEAR(si.p.z, 3 * si.p.x + 20 * si.p.y, 1e-5);  // a plane
    EXPECT_GT(si.n.z, 0);
  }
  EXPECT_NEAR(shape->area(), std::sqrt(1 + 9 + 400.), 1e-4);
  EXPECT_TRUE(shape->canSample());
}

TEST(Heightfield, BadSizesAreRefused) {
  const Param z = floats("Pz", {0, 0, 0, 0});
  EXPECT_THAT(errorOf("heightfield", {z}), HasSubstr("needs \"integer nu\""));
  EXPECT_THAT(errorOf("heightfield", {z, integers("nu", {3}), integers("nv", {2})}),
              HasSubstr("4 values of \"Pz\", but nu * nv is 6"));
  EXPECT_THAT(
      errorOf("heightfield", {z, integers("nu", {2000000000}), integers("nv", {2000000000})}),
      HasSubstr("4000000000000000000"));
  EXPECT_THAT(errorOf("heightfield", {z, integers("nu", {1}), integers("nv", {4})}),
              HasSubstr("nu"));
}

}  // namespace
}  // namespace brume
