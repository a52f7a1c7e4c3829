// SPDX-License-Identifier: Apache-2.0
#include "core/scene.h"

#include <gmock/gmock.h>

#include "core/sampling.h"
#include "core/triangle_mesh.h"
#include "support/shape_cases.h"

namespace brume {
namespace {

using namespace test;

std::vector<Vec3> icosahedron() {
  const float g = 0.5f * (1 + std::sqrt(5.f));
  return {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
          {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
}

std::unique_ptr<Shape> makeIcosahedron(const Transform& t) {
  return makeShape(
      "trianglemesh",
      {points("P", icosahedron()),
       integers("indices", {0, 11, 5,  0, 5,  1, 0, 1, 7, 0, 7,  10, 0, 10, 11, 1, 5, 9, 5, 11,
                            4, 11, 10, 2, 10, 7, 6, 7, 1, 8, 3,  9,  4, 3,  4,  2, 3, 2, 6, 3,
                            6, 8,  3,  8, 9,  4, 9, 5, 2, 4, 11, 6,  2, 10, 8,  6, 7, 9, 8, 1})},
      t);
}

/// A scene of one shape, directly or as an instance.
Scene sceneOf(std::unique_ptr<Shape> shape, const AnimatedTransform* instance = nullptr) {
  Scene::Contents contents;
  const Primitive primitive{shape.get(), nullptr, nullptr};
  contents.shapes.push_back(std::move(shape));
  if (instance) {
    contents.groups.resize(2);
    contents.groups[1].instances.push_back({0, *instance});
  }
  contents.groups[0].primitives.push_back(primitive);
  return Scene(std::move(contents));
}

/// Whether a hit on a triangle is so near to an edge that moving along the normal may pass through
/// the neighbouring face.
bool isAtAnEdge(const SceneHit& hit) {
  if (!hit.primitive->shape->mesh()) return false;
  return std::min({hit.shape.u, hit.shape.v, 1 - hit.shape.u - hit.shape.v}) < 2e-3f;
}

/// Rays that leave a closed convex surface outwards never meet it again; rays that go inside
/// always find the way out, and not at once.
void expectNoSelfIntersection(const Scene& scene, float time = 0) {
  Rng rng(1);
  Stats stats;
  int hits = 0, again = 0, leaks = 0, short_ = 0;
  const Vec3 center = scene.bounds().center();
  const float size = length(scene.bounds().diagonal());
  for (int i = 0; i < 3000; ++i) {
    const Vec3 from = center + sampleUniformSphere(rng.uniform2()) * (size * (1 + rng.uniform()));
    const Vec3 to = randomPoint(rng, scene.bounds(), .3f);
    const FootprintRay ray(Ray{from, normalize(to - from), kInfinity, time});
    const auto si = scene.intersect(ray, stats);
    if (!si || isAtAnEdge(*scene.accelerator().intersect(ray))) continue;
    ++hits;
    const Vec3 outward = dot(si->n, si->wo) > 0 ? si->n : -si->n;  // seen from outside
    const Frame frame = Frame::fromZ(outward);
    // Grazing directions too, as long as their own rounding does not turn them inside.
    Vec3 local = sampleUniformHemisphere(rng.uniform2());
    if (i % 3 == 0) local.z *= 1e-4f;
    const Vec3 away = normalize(frame.fromLocal(local));
    if (dot(Vec3d(away), Vec3d(outward)) > 1e-6)
      again += scene.isOccluded(si->spawnRay(away), stats);
    local.z = -std::max(local.z, 0.05f);
    const Vec3 inside = normalize(frame.fromLocal(local));
    const auto exit = scene.intersect(FootprintRay(si->spawnRay(inside)), stats);
    leaks += !exit;
    short_ += exit && distance(exit->p, si->p) < 1e-5f * size;
  }
  EXPECT_GT(hits, 800);
  EXPECT_EQ(again, 0) << "of " << hits;
  EXPECT_EQ(leaks, 0) << "of " << hits;
  EXPECT_EQ(short_, 0) << "of " << hits;
}

TEST(Scene, SpawnedRaysLeaveTheirSurfaceAtAllScales) {
  for (const double scale : {1e-6, 1e-3, 1., 1e3, 1e6})
    for (const double offset : {0., 3., 300.}) {
      SCOPED_TRACE(testing::Message() << "scale " << scale << " offset " << offset);
      const Transform t = Transform::translate(Vec3d(offset, -0.3 * offset, 0.7 * offset) * scale) *
                          Transform::rotate(33, {1, 2, 3}) * Transform::scale(scale, scale, scale);
      const Transform flat = t * Transform::scale(1, .1, 3);
      for (const Transform& stretched : {t, flat}) {
        SCOPED_TRACE(stretched == t ? "round" : "flat");
        expectNoSelfIntersection(sceneOf(makeShape("sphere", {}, stretched)));
        SCOPED_TRACE("mesh");
        expectNoSelfIntersection(sceneOf(makeIcosahedron(stretched)));
      }
    }
}

TEST(Scene, SpawnedRaysLeaveInstancesAtAllScales) {
  for (const double scale : {1e-6, 1., 1e6})
    for (const double offset : {0., 3., 300.}) {
      SCOPED_TRACE(testing::Message() << "scale " << scale << " offset " << offset);
      const Transform inner = Transform::translate({.3, .2, 5}) * Transform::rotate(70, {0, 1, 3});
      const Transform t = Transform::translate(Vec3d(offset, -0.3 * offset, 0.7 * offset) * scale) *
                          Transform::rotate(33, {1, 2, 3}) *
                          Transform::scale(-scale, 2 * scale, scale);
      const Transform end = t * Transform::rotate(40, {1, 0, 0});
      const AnimatedTransform still(t), moving(t, 0, end, 1);
      expectNoSelfIntersection(sceneOf(makeShape("sphere", {}, inner), &still));
      expectNoSelfIntersection(sceneOf(makeIcosahedron(inner), &still));
      const auto nowhere = AnimatedTransform(t, 0, Transform::translate({scale, 0, 0}) * t, 1);
      expectNoSelfIntersection(sceneOf(makeIcosahedron(inner), &nowhere), 0.f);
    }
}

/// The hard case for a triangle: large, slanted, hit near the origin of coordinates, where p itself
/// has next to no rounding but Embree's plane has; slivers too.
TEST(Scene, SpawnedRaysLeaveLargeTrianglesAndSlivers) {
  Rng rng(5);
  Stats stats;
  int tested = 0, again = 0;
  for (int i = 0; i < 400; ++i) {
    const auto corner = [&] { return sampleUniformSphere(rng.uniform2()) * (1 + rng.uniform()); };
    const Vec3 a = corner(), b = i % 2 ? corner() : -a * rng.uniform() + corner() * 1e-3f;
    const Vec3 c = -(a + b) + corner() * 1e-4f;
    const Scene scene = sceneOf(
        makeShape("trianglemesh", {points("P", {a, b, c}), integers("indices", {0, 1, 2})}));
    for (int k = 0; k < 20; ++k) {
      const float u = .2f + .3f * rng.uniform(), v = .2f + .2f * rng.uniform();
      const ShapeHit hit{1, u, v, 0};
      const SurfaceInteraction si = scene.contents().shapes[0]->interaction(Ray{}, hit);
      const Vec3 w = sampleUniformSphere(rng.uniform2());
      if (absDot(w, si.n) < 1e-5f) continue;
      ++tested;
      again += scene.isOccluded(si.spawnRay(w), stats);
    }
  }
  EXPECT_GT(tested, 7000);
  EXPECT_EQ(again, 0);
}

/// An instance gives the interaction that the shape would give with the whole transform.
TEST(Scene, InstancedInteractionsEqualTransformedShapes) {
  const Transform inner = Transform::rotate(70, {0, 1, 3}) * Transform::scale(1, 2, 1);
  const Transform outer = Transform::translate({3, 4, 5}) * Transform::scale(-1, 2, .5);
  const AnimatedTransform still(outer), moving(inner, 0, outer, 2);
  for (const bool moves : {false, true}) {
    const float time = 1.25f;
    const AnimatedTransform& move = moves ? moving : still;
    const Scene instanced = sceneOf(makeShape("sphere", {}, inner), &move);
    const Scene direct = sceneOf(makeShape("sphere", {}, move.at(time) * inner));
    Stats stats;
    Rng rng(2);
    int hits = 0;
    for (int i = 0; i < 500; ++i) {
      const Vec3 from = randomPoint(rng, direct.bounds(), 3);
      const Vec3 d = normalize(randomPoint(rng, direct.bounds(), .5f) - from);
      const FootprintRay ray(Ray{from, d, kInfinity, time});
      const auto a = instanced.intersect(ray, stats), b = direct.intersect(ray, stats);
      ASSERT_EQ(a.has_value(), b.has_value());
      if (!a || std::abs(dot(b->n, d)) < 0.05f) continue;  // grazing hits differ by rounding
      ++hits;
      EXPECT_LT(distance(a->p, b->p), 1e-4f);
      EXPECT_LT(distance(a->n, b->n), 1e-3f);
      EXPECT_EQ(a->wo, -d);
      EXPECT_EQ(a->time, time);
      const float slope = length(b->geometry.dpdu) + length(b->geometry.dpdv);
      EXPECT_LT(distance(a->geometry.dpdu, b->geometry.dpdu), 1e-3f * slope);
      EXPECT_LT(distance(a->geometry.dpdv, b->geometry.dpdv), 1e-3f * slope);
      const float bend = length(b->geometry.dndu) + length(b->geometry.dndv) + 1;
      EXPECT_LT(distance(a->geometry.dndu, b->geometry.dndu), 1e-2f * bend);
      EXPECT_LT(distance(a->geometry.dndv, b->geometry.dndv), 1e-2f * bend);
    }
    EXPECT_GT(hits, 100);
  }
}

LightSample towards(const Vec3& from, const ShapeSample& s) {
  LightSample sample;
  sample.p = s.p;
  sample.pError = s.pError;
  sample.n = s.n;
  sample.distance = distance(from, s.p);
  sample.wi = (s.p - from) / sample.distance;
  sample.pdf = s.pdf;
  return sample;
}

/// Shadow rays between two shapes in free space are never blocked by the shapes they join.
TEST(Scene, ShadowRaysEndBeforeTheLight) {
  for (const double scale : {1e-6, 1., 1e6})
    for (const double distanceTo : {3., 100., 1e4}) {
      SCOPED_TRACE(testing::Message() << "scale " << scale << " distance " << distanceTo);
      const Transform s = Transform::scale(scale, scale, scale);
      const Transform far = s * Transform::translate({0.3 * distanceTo, 0, distanceTo}) *
                            Transform::rotate(20, {1, 2, 0});
      for (const char* plugin : {"sphere", "disk"}) {
        Scene::Contents contents;
        contents.shapes.push_back(makeIcosahedron(s));
        contents.shapes.push_back(makeShape(plugin, {}, far));
        for (const auto& shape : contents.shapes)
          contents.groups[0].primitives.push_back({shape.get(), nullptr, nullptr});
        const Shape& light = *contents.shapes[1];
        const Shape& lit = *contents.shapes[0];
        const Scene scene(std::move(contents));
        Stats stats;
        Rng rng(3);
        int blocked = 0, tested = 0;
        for (int i = 0; i < 2000; ++i) {
          const ShapeSample on = lit.sampleArea(rng.uniform2());
          SurfaceInteraction from;
          from.p = on.p;
          from.pError = on.pError;
          from.n = on.n;
          const auto sample = light.sampleSolidAngle(from.p, rng.uniform2());
          if (!sample) continue;
          const LightSample to = towards(from.p, *sample);
          if (dot(from.n, to.wi) <= 1e-3f) continue;
          // A sphere sampled from within a hair of its silhouette may hide its own point.
          if (absDot(to.n, to.wi) < 1e-3f) continue;
          ++tested;
          const Ray ray = Scene::shadowRay(from, to);
          blocked += scene.isOccluded(ray, stats);
          EXPECT_NEAR(ray.tMax / to.distance, 1, 1e-3);
          blocked += scene.isOccluded(Scene::shadowRay(ray.o, 0, to), stats);
        }
        EXPECT_GT(tested, 300);
        EXPECT_EQ(blocked, 0);
      }
    }
}

TEST(Scene, ShadowRaysToInfinityAndToNowhere) {
  LightSample to;
  to.wi = {0, 1, 0};
  EXPECT_EQ(Scene::shadowRay(Vec3(1, 2, 3), 0.5f, to).tMax, kInfinity);
  EXPECT_EQ(Scene::shadowRay(Vec3(1, 2, 3), 0.5f, to).time, 0.5f);
  to.distance = 0;
  to.p = {1, 2, 3};
  const Ray ray = Scene::shadowRay(Vec3(1, 2, 3), 0, to);
  EXPECT_EQ(ray.tMax, 0);
  EXPECT_TRUE(isFinite(ray.d));
}

TEST(Scene, CountsRaysAndBoundsAnEmptyScene) {
  const Scene scene{Scene::Contents()};
  Stats stats;
  EXPECT_FALSE(scene.intersect(FootprintRay(Ray{}), stats));
  EXPECT_FALSE(scene.isOccluded(Ray{}, stats));
  EXPECT_EQ(stats[Stat::IntersectionRays], 1u);
  EXPECT_EQ(stats[Stat::ShadowRays], 1u);
  EXPECT_EQ(scene.bounds().radius(), 0);
  EXPECT_EQ(scene.volume(), nullptr);
}

}  // namespace
}  // namespace brume
