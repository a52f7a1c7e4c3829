// SPDX-License-Identifier: Apache-2.0
#include "core/quadric.h"

#include <gmock/gmock.h>

#include "core/sampling.h"
#include "support/shape_cases.h"

namespace brume {
namespace {

using namespace test;
using testing::HasSubstr;

/// Runs body for every quadric under every transform.
void forAll(
    const std::function<void(const QuadricCase&, const TransformCase&, const Shape&)>& body) {
  for (const QuadricCase& q : quadricCases())
    for (const TransformCase& t : transformCases()) {
      SCOPED_TRACE(q.label + ", " + t.label);
      const auto shape = makeShape(q.plugin, q.params, t.transform);
      ASSERT_TRUE(shape);
      body(q, t, *shape);
      if (testing::Test::HasFailure()) return;
    }
}

/// Whether a surface point lies in the error box of p: the implicit function is at most what its
/// gradient times the box allows (to first order; boxes are a few ulps).
void expectOnSurface(const QuadricCase& q, const TransformCase& t, const Vec3& p,
                     const Vec3& pError) {
  const Transform inverse = t.transform.inverse();
  const Vec3d o = apply(inverse, Vec3d(p));
  double allowed = 0, h = 1e-4;
  Vec3d gradient;  // object space
  for (int i = 0; i < 3; ++i) {
    Vec3d e(0);
    e[i] = h;
    gradient[i] = (q.implicit(o + e) - q.implicit(o - e)) / (2 * h);
  }
  const glm::dmat3 linear(inverse.matrix());
  for (int i = 0; i < 3; ++i) allowed += std::abs(dot(gradient, linear[i])) * pError[i];
  // Second order near a cone's apex, and the doubles of this test itself.
  double second = 0;
  for (int i = 0; i < 3; ++i) second += dot(linear[i], linear[i]) * pError[i] * pError[i];
  EXPECT_LE(std::abs(q.implicit(o)), 1.001 * allowed + 30 * second + 1e-12);
}

TEST(Quadric, RaysTowardsPointsOfTheSurfaceHitItAtTheirParameters) {
  forAll([](const QuadricCase& q, const TransformCase& t, const Shape& shape) {
    Rng rng(1);
    const float size = length(shape.bounds().diagonal());
    for (int i = 0; i < 200; ++i) {
      const double u = rng.uniformDouble(), v = rng.uniformDouble();
      const Vec3d target = apply(t.transform, q.at(u, v));
      const Vec3 origin = randomPoint(rng, shape.bounds(), 4);
      const Vec3 direction = normalize(Vec3(target - Vec3d(origin)));
      const Ray ray{origin, direction};
      const std::optional<ShapeHit> hit = shape.intersect(ray);
      // Rounding may push a ray past an edge, or a grazing one off the surface.
      if (!hit) {
        const bool nearEdge = u < 1e-3 || u > 0.999 || v < 1e-3 || v > 0.999;
        const Vec3d n = cross(q.at(u + 1e-4, v) - q.at(u, v), q.at(u, v + 1e-4) - q.at(u, v));
        const Vec3d d = apply(t.transform.inverse(), Vec3d(origin)) - q.at(u, v);
        EXPECT_TRUE(nearEdge || std::abs(dot(normalize(n), normalize(d))) < 0.02) << u << ' ' << v;
        continue;
      }
      ASSERT_TRUE(shape.bounds().contains(ray(hit->t)) || hit->t > 1e4f * size ||
                  distance(shape.bounds().center(), ray(hit->t)) < 0.51f * size + 1e-5f * hit->t);
      // No later than the target, by its own rounding and that of the direction, which a grazing
      // surface turns into a longer way.
      const double way = length(target - Vec3d(origin));
      const double cosine = absDot(shape.interaction(ray, *hit).n, direction);
      EXPECT_LE(hit->t, way + 1e-6 * (way + length(target)) / std::max(cosine, 1e-4));
      const SurfaceInteraction si = shape.interaction(ray, *hit);
      expectOnSurface(q, t, si.p, si.pError);
      // The parameters name the point that was hit; 1e-5 of the size is float uv.
      const Vec3d named = apply(t.transform, q.at(si.uv.x, si.uv.y));
      EXPECT_LT(length(named - Vec3d(si.p)), 2e-5 * size + 4 * length(si.pError));
      EXPECT_LT(length(Vec3d(ray(hit->t)) - Vec3d(si.p)),
                1e-5 * size + 1e-6 * hit->t + 4 * length(si.pError));
    }
  });
}

TEST(Quadric, DerivativesAgreeWithDifferences) {
  forAll([](const QuadricCase& q, const TransformCase& t, const Shape& shape) {
    Rng rng(2);
    const auto at = [&](double u, double v) { return apply(t.transform, q.at(u, v)); };
    const double h = 1e-4;
    const auto du = [&](double u, double v) { return (at(u + h, v) - at(u - h, v)) / (2 * h); };
    const auto dv = [&](double u, double v) { return (at(u, v + h) - at(u, v - h)) / (2 * h); };
    const double side = t.transform.swapsHandedness() ? -1 : 1;
    const auto n = [&](double u, double v) { return normalize(cross(du(u, v), dv(u, v))) * side; };
    for (int i = 0; i < 50; ++i) {
      const double u = 0.05 + 0.9 * rng.uniform(), v = 0.05 + 0.9 * rng.uniform();
      const Vec3d p = at(u, v), away = n(u, v);
      const double size = length(shape.bounds().diagonal());
      const Ray ray{Vec3(p + away * (0.01 * size)), Vec3(-away)};
      const std::optional<ShapeHit> hit = shape.intersect(ray);
      ASSERT_TRUE(hit);
      const SurfaceInteraction si = shape.interaction(ray, *hit);
      const double x = si.uv.x, y = si.uv.y;
      // Differences are good to h^2 times the third derivative, and to the doubles' 1e-16/h (times
      // the distance, when far away).
      const double slack = 2e-5 + 1e-11 * length(p) / size;
      const auto near = [&](const Vec3& got, const Vec3d& want, double scale) {
        EXPECT_LT(length(Vec3d(got) - want), slack * scale) << x << ' ' << y;
      };
      near(si.n, n(x, y), 1);
      near(si.ns, n(x, y), 1);
      near(si.geometry.dpdu, du(x, y), size);
      near(si.geometry.dpdv, dv(x, y), size);
      const double k = 1e-3, noise = 50 + 1e4 * length(p) * 1e-9 / size;
      near(si.geometry.dndu, (n(x + k, y) - n(x - k, y)) / (2 * k), noise * 20);
      near(si.geometry.dndv, (n(x, y + k) - n(x, y - k)) / (2 * k), noise * 20);
    }
  });
}

TEST(Quadric, AreaIsTheClosedForm) {
  forAll([](const QuadricCase& q, const TransformCase& t, const Shape& shape) {
    if (t.similarity > 0) {
      EXPECT_NEAR(shape.area() / (q.area * t.similarity * t.similarity), 1, 1e-6);
      return;
    }
    // Midpoint rule over the parameters, whose error and that of the shape's own are below 1e-3.
    double area = 0;
    constexpr int kCells = 128;
    for (int i = 0; i < kCells; ++i)
      for (int j = 0; j < kCells; ++j) {
        const double u = (i + 0.5) / kCells, v = (j + 0.5) / kCells, h = 1e-4;
        const auto at = [&](double a, double b) { return apply(t.transform, q.at(a, b)); };
        area += length(cross(at(u + h, v) - at(u - h, v), at(u, v + h) - at(u, v - h))) /
                (4 * h * h * kCells * kCells);
      }
    EXPECT_NEAR(shape.area() / area, 1, 1e-3);
  });
}

/// Samples counted in cells of (u, v) against the integral of the stated density over each cell.
/// Surface parameters of a sampled point: those of the hit by a ray that falls on it.
Vec2 uvOf(const Shape& shape, const ShapeSample& s) {
  // So near that nothing else of the shape comes between.
  const float height = 1e-5f * length(shape.bounds().diagonal()) + 8 * length(s.pError);
  const Ray ray{s.p + s.n * height, -s.n};
  const auto hit = shape.intersect(ray);
  return hit ? shape.interaction(ray, *hit).uv : Vec2(0);
}

TEST(Quadric, SamplesFollowTheirDensity) {
  forAll([](const QuadricCase& q, const TransformCase& t, const Shape& shape) {
    constexpr int kCells = 6, kFine = 6, kSamples = 6000;
    std::vector<double> counted(kCells * kCells), expected(kCells * kCells);
    Rng rng(3);
    for (int i = 0; i < kSamples; ++i) {
      const ShapeSample s = shape.sampleArea(rng.uniform2());
      expectOnSurface(q, t, s.p, s.pError);
      const Vec2 uv = uvOf(shape, s);
      const int x = std::clamp(static_cast<int>(uv.x * kCells), 0, kCells - 1);
      const int y = std::clamp(static_cast<int>(uv.y * kCells), 0, kCells - 1);
      counted[y * kCells + x] += 1;
      ASSERT_FLOAT_EQ(s.pdf, shape.pdfArea(s.p, s.n));
    }
    const double side = t.transform.swapsHandedness() ? -1 : 1;
    for (int j = 0; j < kCells * kFine; ++j)
      for (int i = 0; i < kCells * kFine; ++i) {
        const double step = 1.0 / (kCells * kFine), u = (i + 0.5) * step, v = (j + 0.5) * step;
        const double h = 1e-4;
        const auto at = [&](double a, double b) { return apply(t.transform, q.at(a, b)); };
        const Vec3d n =
            cross(at(u + h, v) - at(u - h, v), at(u, v + h) - at(u, v - h)) / (4 * h * h);
        const double pdf = shape.pdfArea(Vec3(at(u, v)), Vec3(normalize(n) * side));
        expected[j / kFine * kCells + i / kFine] += pdf * length(n) * step * step * kSamples;
      }
    double chi2 = 0, total = 0;
    for (int c = 0; c < kCells * kCells; ++c) {
      chi2 += (counted[c] - expected[c]) * (counted[c] - expected[c]) / expected[c];
      total += expected[c];
    }
    EXPECT_NEAR(total / kSamples, 1, 2e-3);  // the midpoint rule's error
    EXPECT_LT(chi2, 90);  // 35 degrees of freedom: exceeded with probability 1e-6, 63 cases
  });
}

TEST(Quadric, SampledAndHitNormalsAgree) {
  for (const bool reverse : {false, true})
    for (const QuadricCase& q : quadricCases())
      for (const TransformCase& t : transformCases()) {
        SCOPED_TRACE(q.label + ", " + t.label);
        const auto shape = makeShape(q.plugin, q.params, t.transform, reverse);
        const float size = length(shape->bounds().diagonal());
        Rng rng(4);
        for (int i = 0; i < 20; ++i) {
          const ShapeSample s = shape->sampleArea(rng.uniform2());
          const Ray ray{s.p + s.n * (1e-3f * size), -s.n};
          const std::optional<ShapeHit> hit = shape->intersect(ray);
          if (!hit) continue;  // at an edge
          const SurfaceInteraction si = shape->interaction(ray, *hit);
          EXPECT_GT(dot(si.n, s.n), 0.9f);
        }
      }
}

TEST(Quadric, SolidAngleDensityIsThatOfTheSamples) {
  forAll([](const QuadricCase& q, const TransformCase&, const Shape& shape) {
    Rng rng(5);
    const Vec3 ref = shape.bounds().center() + shape.bounds().diagonal() * Vec3(1.2f, 0.7f, -0.4f);
    const float size = length(shape.bounds().diagonal());
    // Far away, float ref and hit points limit the cosine.
    const double slack = 1e-3 + 1e-5 * length(ref) / size;
    for (int i = 0; i < 100; ++i) {
      const std::optional<ShapeSample> s = shape.sampleSolidAngle(ref, rng.uniform2());
      if (!s) continue;
      const Vec3 wi = normalize(s->p - ref);
      if (absDot(wi, s->n) < 0.05f) continue;
      EXPECT_NEAR(shape.pdfSolidAngle(ref, wi, s->p, s->n) / s->pdf, 1, slack) << q.label;
    }
  });
}

/// The density of directions integrates to 1 over the sphere of directions: partial ones,
/// ellipsoids and points inside too.
TEST(Sphere, DirectionDensityIntegratesToOne) {
  const Transform stretch = Transform::rotate(30, {1, 1, 0}) * Transform::scale(1, 2, 0.5);
  for (const Transform& t : {Transform(), stretch})
    for (const Vec3& ref : {Vec3(1.5f, 2.5f, 0.3f), Vec3(0.1f, -0.2f, 0.05f)}) {
      const auto shape = makeShape("sphere", {}, t);
      Rng rng(6);
      double sum = 0, sum2 = 0;
      constexpr int kDirections = 60000;
      for (int i = 0; i < kDirections; ++i) {
        const Ray ray{ref, sampleUniformSphere(rng.uniform2())};
        double value = 0;
        if (const auto hit = shape->intersect(ray)) {
          const SurfaceInteraction si = shape->interaction(ray, *hit);
          value = 4 * kPiD * shape->pdfSolidAngle(ref, ray.d, si.p, si.n);
        }
        sum += value;
        sum2 += value * value;
      }
      const double mean = sum / kDirections;
      const double sigma = std::sqrt((sum2 / kDirections - mean * mean) / kDirections);
      EXPECT_NEAR(mean, 1, 4.5 * sigma + 1e-4);
    }
}

TEST(Sphere, ConeSamplingIsExactForTinyAndFarSpheres) {
  for (const double radius : {1e-6, 1e-3, 1.0, 1e3})
    for (const float distanceInRadii : {1.001f, 2.f, 1e3f, 1e6f}) {
      const auto shape = makeShape("sphere", {floats("radius", {static_cast<float>(radius)})});
      const double d = radius * distanceInRadii;
      const Vec3 ref(0, static_cast<float>(d), 0);
      const double s2 = radius * radius / (double{ref.y} * ref.y);
      const double solidAngle = 2 * kPiD * s2 / (1 + std::sqrt(1 - s2));
      Rng rng(7);
      for (int i = 0; i < 50; ++i) {
        const std::optional<ShapeSample> s = shape->sampleSolidAngle(ref, rng.uniform2());
        ASSERT_TRUE(s);
        EXPECT_NEAR(s->pdf * solidAngle, 1, 1e-5);
        EXPECT_NEAR(length(s->p) / radius, 1, 1e-6);
        EXPECT_GT(dot(s->n, ref - s->p), -1e-3 * d);  // the side that is seen
      }
    }
}

TEST(Sphere, RaysFromAfarFindItsEdge) {
  // At 1e6 radii a float quadratic has lost the radius altogether.
  const auto shape = makeShape("sphere", {});
  int hits = 0;
  constexpr int kRays = 4000;
  Rng rng(8);
  for (int i = 0; i < kRays; ++i) {
    const Vec2 disk(4 * rng.uniform() - 2, 4 * rng.uniform() - 2);
    const bool inside = disk.x * disk.x + disk.y * disk.y < 1;
    const bool hit = shape->intersect({Vec3(disk.x, disk.y, -1e6f), Vec3(0, 0, 1)}).has_value();
    EXPECT_EQ(hit, inside) << disk.x << ' ' << disk.y;
    hits += hit;
  }
  EXPECT_GT(hits, 600);
}

TEST(Disk, ShinesTowardsPlusZ) {
  const auto shape = makeShape("disk", {floats("radius", {1})});
  EXPECT_EQ(shape->sampleArea({0.3f, 0.7f}).n, Vec3(0, 0, 1));
  for (const float from : {-1.f, 1.f}) {
    const Ray ray{{0.2f, 0.1f, from}, {0, 0, -from}};
    EXPECT_EQ(shape->interaction(ray, *shape->intersect(ray)).n, Vec3(0, 0, 1));
  }
}

TEST(Quadric, PolesApexAndCentreHaveFiniteGeometry) {
  for (const char* plugin : {"sphere", "disk", "cone", "paraboloid", "hyperboloid"}) {
    SCOPED_TRACE(plugin);
    const auto shape = makeShape(plugin, {});
    for (const float z : {5.f, -5.f}) {
      const Ray ray{{0, 0, z}, {0, 0, z > 0 ? -1.f : 1.f}};
      const std::optional<ShapeHit> hit = shape->intersect(ray);
      if (!hit) continue;  // a cone is open at its base, its apex a single point
      const SurfaceInteraction si = shape->interaction(ray, *hit);
      for (const Vec3& v : {si.p, si.pError, si.n, si.geometry.dpdu, si.geometry.dpdv,
                            si.geometry.dndu, si.geometry.dndv})
        EXPECT_TRUE(isFinite(v));
      EXPECT_NEAR(length(si.n), 1, 1e-6);
      EXPECT_GT(length(si.geometry.dpdu), 0);
    }
  }
}

TEST(Quadric, EndsOfTheParameterRanges) {
  const float tiny = 1e-18f, large = 1e18f;
  for (const char* plugin : {"sphere", "disk", "cylinder", "cone", "paraboloid"})
    for (const float r : {tiny, large})
      for (const float phi : {1e-3f, 360.f}) {
        SCOPED_TRACE(plugin);
        const auto shape = makeShape(plugin, {floats("radius", {r}), floats("phimax", {phi})});
        EXPECT_TRUE(std::isfinite(shape->area()));
        const ShapeSample s = shape->sampleArea({0.5f, 0.5f});
        EXPECT_TRUE(isFinite(s.p) && isFinite(s.n));
      }
}

std::string errorOf(const char* plugin, std::vector<Param> params) {
  try {
    makeShape(plugin, std::move(params));
  } catch (const SceneError& e) {
    return e.what();
  }
  return "no error";
}

TEST(Quadric, BadGeometryIsRefused) {
  EXPECT_THAT(errorOf("sphere", {floats("radius", {0})}), HasSubstr("radius"));
  EXPECT_THAT(errorOf("sphere", {floats("radius", {-1})}), HasSubstr("radius"));
  EXPECT_THAT(errorOf("sphere", {floats("zmin", {.5f}), floats("zmax", {-.5f})}),
              HasSubstr("zmin must be smaller"));
  EXPECT_THAT(errorOf("sphere", {floats("zmin", {2}), floats("zmax", {3})}), HasSubstr("nothing"));
  EXPECT_THAT(errorOf("sphere", {floats("radius", {1e30f})}), HasSubstr("1.8e18"));
  EXPECT_THAT(errorOf("disk", {floats("innerradius", {1})}), HasSubstr("innerradius"));
  EXPECT_THAT(errorOf("disk", {floats("phimax", {0})}), HasSubstr("phimax"));
  EXPECT_THAT(errorOf("cylinder", {floats("zmin", {1})}), HasSubstr("zmin must be smaller"));
  EXPECT_THAT(errorOf("cone", {floats("height", {-1})}), HasSubstr("height"));
  EXPECT_THAT(errorOf("paraboloid", {floats("zmin", {1})}), HasSubstr("zmin must be smaller"));
  EXPECT_THAT(errorOf("hyperboloid", {points("p2", {{1, 0, 0}})}), HasSubstr("differ in z"));
  EXPECT_THAT(errorOf("hyperboloid", {points("p2", {{0, 0, 1}})}), HasSubstr("z axis"));
}

}  // namespace
}  // namespace brume
