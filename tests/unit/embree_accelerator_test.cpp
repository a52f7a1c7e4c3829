// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "core/accelerator.h"
#include "core/parallel.h"
#include "core/sampling.h"
#include "core/triangle_mesh.h"
#include "support/shape_cases.h"

namespace brume {
namespace {

using namespace test;

/// Shapes and the groups made of them; materials play no part.
struct World {
  std::vector<std::unique_ptr<Shape>> shapes;
  std::vector<PrimitiveGroup> groups{1};

  Primitive add(std::unique_ptr<Shape> shape) {
    shapes.push_back(std::move(shape));
    return {shapes.back().get(), nullptr, nullptr};
  }
  PrimitiveGroup& top() { return groups.back(); }
};

std::unique_ptr<Shape> randomTriangles(Rng& rng, int count, float size) {
  std::vector<Vec3> P;
  std::vector<int> indices;
  for (int i = 0; i < count; ++i) {
    const Vec3 c(rng.uniform(), rng.uniform(), rng.uniform());
    for (int k = 0; k < 3; ++k) {
      indices.push_back(static_cast<int>(P.size()));
      P.push_back(c + (Vec3(rng.uniform(), rng.uniform(), rng.uniform()) - 0.5f) * size);
    }
  }
  return makeShape("trianglemesh", {points("P", P), integers("indices", indices)});
}

Ray randomRay(Rng& rng, const Bounds3& b) {
  const Vec3 from = randomPoint(rng, b, 3), to = randomPoint(rng, b, 0.6f);
  return {from, normalize(to - from)};
}

/// The nearest triangle in double (Moeller, Trumbore 1997); margin: how far the barycentrics are
/// inside, so that rays through edges can be left out.
struct BruteHit {
  double t = std::numeric_limits<double>::infinity(), margin = 0;
  std::uint32_t triangle = 0;
};
BruteHit bruteForce(const TriangleMesh& mesh, const Ray& ray) {
  BruteHit best;
  const Vec3d o(ray.o), d(ray.d);
  for (std::uint32_t i = 0; i < mesh.triangleCount(); ++i) {
    const int* v = mesh.indexData() + 3 * i;
    const Vec3d p0(mesh.pointData()[v[0]]), e1 = Vec3d(mesh.pointData()[v[1]]) - p0,
                                            e2 = Vec3d(mesh.pointData()[v[2]]) - p0,
                                            s = cross(d, e2), q = cross(o - p0, e1);
    const double det = dot(s, e1);
    if (det == 0) continue;
    const double u = dot(o - p0, s) / det, w = dot(d, q) / det, t = dot(e2, q) / det;
    const double margin = std::min({u, w, 1 - u - w});
    if (t > 0 && margin >= 0 && t < best.t) best = {t, margin, i};
  }
  return best;
}

TEST(EmbreeAccelerator, EqualsBruteForceOnTriangles) {
  Rng rng(1);
  for (const float size : {0.05f, 0.4f}) {
    World w;
    w.top().primitives.push_back(w.add(randomTriangles(rng, 300, size)));
    const TriangleMesh& mesh = *w.shapes[0]->mesh();
    const auto accelerator = buildEmbreeAccelerator(w.groups);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
      const Ray ray = randomRay(rng, accelerator->bounds());
      const BruteHit expected = bruteForce(mesh, ray);
      const std::optional<SceneHit> hit = accelerator->intersect(ray);
      if (std::isfinite(expected.t) && expected.margin < 1e-5) continue;  // through an edge
      ASSERT_EQ(hit.has_value(), std::isfinite(expected.t));
      EXPECT_EQ(accelerator->occluded(ray), hit.has_value());
      if (!hit) continue;
      ++hits;
      EXPECT_EQ(hit->shape.primitive, expected.triangle);
      EXPECT_EQ(hit->primitive, &w.top().primitives[0]);
      EXPECT_NEAR(hit->shape.t, expected.t, 1e-4);
      // The barycentrics name the point of the ray.
      const Vec3 p = mesh.interaction(ray, hit->shape).p;
      EXPECT_LT(distance(p, ray(hit->shape.t)), 1e-4f);
      // Ending the ray before or behind the hit decides.
      Ray shortened = ray;
      shortened.tMax = hit->shape.t * 0.999f;
      EXPECT_FALSE(accelerator->occluded(shortened));
      shortened.tMax = hit->shape.t * 1.001f;
      EXPECT_TRUE(accelerator->occluded(shortened));
    }
    EXPECT_GT(hits, 50);
  }
}

TEST(EmbreeAccelerator, EqualsTheShapesOnQuadrics) {
  Rng rng(2);
  World w;
  for (const QuadricCase& q : quadricCases())
    for (int i = 0; i < 4; ++i) {
      const Vec3d at(10 * rng.uniform(), 10 * rng.uniform(), 10 * rng.uniform());
      w.top().primitives.push_back(w.add(makeShape(
          q.plugin, q.params, Transform::translate(at) * Transform::rotate(60 * i, {1, 2, 3}))));
    }
  w.top().primitives.push_back(w.add(randomTriangles(rng, 20, 0.5f)));
  const auto accelerator = buildEmbreeAccelerator(w.groups);
  for (int i = 0; i < 2000; ++i) {
    const Ray ray = randomRay(rng, accelerator->bounds());
    std::optional<ShapeHit> nearest;
    const Primitive* which = nullptr;
    for (const Primitive& p : w.top().primitives) {
      Ray rest = ray;
      if (nearest) rest.tMax = nearest->t;
      if (const auto hit = p.shape->intersect(rest)) nearest = hit, which = &p;
    }
    const BruteHit triangle = bruteForce(*w.shapes.back()->mesh(), ray);
    const double t = nearest ? nearest->t : std::numeric_limits<double>::infinity();
    if (triangle.t < t) continue;
    const std::optional<SceneHit> hit = accelerator->intersect(ray);
    ASSERT_EQ(hit.has_value(), nearest.has_value());
    EXPECT_EQ(accelerator->occluded(ray), hit.has_value());
    if (!hit) continue;
    EXPECT_EQ(hit->primitive, which);
    EXPECT_EQ(hit->shape.t, nearest->t);
  }
}

TEST(EmbreeAccelerator, EmptyAndDegenerateScenesAreMissed) {
  World empty;
  const auto nothing = buildEmbreeAccelerator(empty.groups);
  EXPECT_FALSE(nothing->intersect({{0, 0, 0}, {0, 0, 1}}));
  EXPECT_FALSE(nothing->occluded({{0, 0, 0}, {0, 0, 1}}));
  EXPECT_TRUE(nothing->bounds().isEmpty());

  World flat;
  flat.top().primitives.push_back(
      flat.add(makeShape("trianglemesh", {points("P", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}),
                                          integers("indices", {0, 1, 2, 0, 0, 0, 1, 1, 2})})));
  const auto lines = buildEmbreeAccelerator(flat.groups);
  for (float x = 0; x < 2; x += 0.25f) EXPECT_FALSE(lines->occluded({{x, 0, -1}, {0, 0, 1}}));

  // Groups that are empty, rays that are not rays.
  World w;
  w.groups.resize(2);
  w.top().instances.push_back({0, AnimatedTransform(Transform())});
  w.top().primitives.push_back(w.add(makeShape("sphere", {})));
  const auto sphere = buildEmbreeAccelerator(w.groups);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(sphere->intersect({{0, 0, -3}, {0, 0, 1}, 0.f}));
  EXPECT_FALSE(sphere->intersect({{0, 0, -3}, {0, 0, 1}, nan}));
  EXPECT_FALSE(sphere->intersect({{nan, 0, -3}, {0, 0, 1}}));
  EXPECT_FALSE(sphere->intersect({{0, 0, -3}, {nan, nan, nan}}));
  EXPECT_FALSE(sphere->intersect({{0, 0, -3}, {0, 0, 0}}));
  EXPECT_TRUE(sphere->intersect({{0, 0, -3}, {0, 0, 1}}));
  EXPECT_GT(sphere->memoryBytes(), 0u);
}

class HalfTexture final : public Texture<float> {
 public:
  float evaluate(const TextureContext& at) const override { return at.p.x > 100.5f ? 1.f : 0.f; }
};

TEST(EmbreeAccelerator, AlphaCutsWhereItIsZero) {
  const HalfTexture texture;
  MeshData data;
  data.indices = {0, 1, 2, 0, 2, 3};
  data.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  data.alpha = FloatSlot{1.f, &texture};
  Shape::FactoryContext context;
  context.sceneOrigin = {100, 0, 0};  // the texture sees scene space
  World w;
  w.top().primitives.push_back(w.add(std::make_unique<TriangleMesh>(data, context)));
  w.top().primitives.push_back(w.add(makeShape("disk", {floats("height", {1})})));
  const auto accelerator = buildEmbreeAccelerator(w.groups);
  for (float x = 0.05f; x < 0.7f; x += 0.1f) {
    Ray ray{{x, 0.5f, -1}, {0, 0, 1}};
    ASSERT_TRUE(accelerator->intersect(ray));
    EXPECT_FLOAT_EQ(accelerator->intersect(ray)->shape.t, x > 0.5f ? 1 : 2);
    ray.tMax = 1.5f;
    EXPECT_EQ(accelerator->occluded(ray), x > 0.5f);
  }
}

/// Rays against still and moving instances agree with rays carried into the group by at(time).
TEST(EmbreeAccelerator, InstancesMoveAsTheirTransform) {
  Rng rng(3);
  World w;
  w.groups.resize(2);
  w.groups[0].primitives.push_back(w.add(randomTriangles(rng, 60, 0.5f)));
  w.groups[0].primitives.push_back(w.add(makeShape("sphere", {floats("radius", {0.4f})})));
  const Transform a = Transform::translate({-2, 0, 0}) * Transform::scale(1, 2, 1);
  const Transform b = Transform::translate({2, 1, 0}) * Transform::rotate(170, {1, 1, 0}) *
                      Transform::scale(-2, 1, 0.5);
  const Transform c = Transform::translate({0, 4, 0}) * Transform::rotate(50, {0, 1, 1});
  const std::vector<AnimatedTransform> moves{
      AnimatedTransform(Transform::translate({0, -4, 0}) * a),
      AnimatedTransform(a, 0.25f, c, 0.75f), AnimatedTransform(Transform::translate({3, 0, 0}) * b),
      AnimatedTransform(c, -1.f, b, 3.f)};
  for (const AnimatedTransform& move : moves) w.top().instances.push_back({0, move});
  const auto accelerator = buildEmbreeAccelerator(w.groups);
  World alone;
  alone.top().primitives = w.groups[0].primitives;
  const auto inside = buildEmbreeAccelerator(alone.groups);

  int hits = 0, differing = 0;
  for (int i = 0; i < 4000; ++i) {
    Ray ray = randomRay(rng, accelerator->bounds());
    ray.time = -1.5f + 5 * rng.uniform();
    float nearest = kInfinity;
    const PrimitiveGroup::Instance* which = nullptr;
    const Primitive* primitive = nullptr;
    for (const auto& instance : w.top().instances) {
      const Ray local = instance.groupToParent.at(ray.time).inverse().ray(ray);
      const auto hit = inside->intersect(local);
      if (!hit || hit->shape.t >= nearest) continue;
      nearest = hit->shape.t;
      which = &instance;
      primitive = &w.groups[0].primitives[std::size_t(hit->primitive - &alone.top().primitives[0])];
    }
    const std::optional<SceneHit> hit = accelerator->intersect(ray);
    EXPECT_EQ(accelerator->occluded(ray), hit.has_value());
    // Float rounding of the ray differs, which may decide at a silhouette.
    if (hit.has_value() != (which != nullptr) ||
        (hit && std::abs(hit->shape.t - nearest) > 1e-3f * nearest)) {
      ++differing;
      continue;
    }
    if (!hit) continue;
    ++hits;
    EXPECT_EQ(hit->instance, which);
    EXPECT_EQ(hit->primitive, primitive);
    EXPECT_NEAR(hit->shape.t, nearest, 1e-4f * nearest);
  }
  EXPECT_GT(hits, 200);
  EXPECT_LE(differing, 4);  // one in a thousand
}

TEST(EmbreeAccelerator, EqualDistancesDoNotDependOnTheThreads) {
  // Coincident layers: which one is hit is a matter of the order in the tree alone.
  World w;
  std::vector<Vec3> P;
  std::vector<int> indices;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 corner(float(i % 20), float(i / 20 % 20), 0);
    for (const Vec3& offset : {Vec3(0), Vec3(1, 0, 0), Vec3(1, 1, 0)}) {
      indices.push_back(static_cast<int>(P.size()));
      P.push_back(corner + offset);
    }
  }
  w.top().primitives.push_back(
      w.add(makeShape("trianglemesh", {points("P", P), integers("indices", indices)})));
  std::vector<std::uint32_t> first;
  for (const int threads : {1, 2, 7}) {
    setThreadCount(threads);
    const auto accelerator = buildEmbreeAccelerator(w.groups);
    Rng rays(5);
    std::vector<std::uint32_t> found;
    for (int i = 0; i < 500; ++i) {
      const auto hit = accelerator->intersect(
          {Vec3(20 * rays.uniform(), 20 * rays.uniform(), 1), Vec3(0, 0, -1)});
      found.push_back(hit ? hit->shape.primitive : ~0u);
    }
    if (first.empty()) first = found;
    EXPECT_EQ(found, first) << threads;
  }
  setThreadCount(0);
}

}  // namespace
}  // namespace brume
