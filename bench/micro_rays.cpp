// SPDX-License-Identifier: Apache-2.0
// Rays per second: Embree behind the accelerator's interface, and with what Scene adds to it.
#include <benchmark/benchmark.h>

#include "core/rng.h"
#include "core/sampling.h"
#include "core/scene.h"
#include "micro_wavy_grid.h"
#include "support/make_plugin.h"

namespace brume::bench {
namespace {

/// Half a million triangles.
const Scene& scene() {
  static const Scene result = [] {
    WavyGrid grid = wavyGrid(512);
    Scene::Contents contents;
    contents.shapes.push_back(
        test::make<Shape>("trianglemesh", {test::points("P", std::move(grid.points)),
                                           test::integers("indices", std::move(grid.indices))}));
    contents.materials.push_back(test::make<Material>("matte", {}));
    contents.groups[0].primitives.push_back(
        {contents.shapes[0].get(), contents.materials[0].get(), nullptr});
    return Scene(std::move(contents));
  }();
  return result;
}

enum class Order { Coherent, Random };

/// Rays that meet the mesh: from above, neighbours beside each other or all mixed up.
std::vector<FootprintRay> raysFromAbove(Order order) {
  constexpr int kSide = 128;
  Rng rng(1);
  std::vector<FootprintRay> rays;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2 u = rng.uniform2();
    const Vec2 target =
        order == Order::Random ? rng.uniform2() : (Vec2(i % kSide, i / kSide) + u) / float(kSide);
    const Vec3 from = order == Order::Random ? Vec3(u, 0.1f + rng.uniform()) : Vec3(.5f, -.5f, 1);
    rays.emplace_back(Ray(from, normalize(Vec3(target, 0) - from)));
  }
  return rays;
}

/// From points of the mesh into the upper hemisphere: few are blocked, all search.
std::vector<Ray> shadowRays() {
  Rng rng(2);
  Stats stats;
  std::vector<Ray> rays;
  for (const FootprintRay& ray : raysFromAbove(Order::Random))
    if (const auto hit = scene().intersect(ray, stats)) {
      const Vec3 w = normalize(sampleUniformHemisphere(rng.uniform2()) + Vec3(0, 0, .02f));
      rays.push_back(hit->spawnRay(w, 1));
    }
  return rays;
}

/// Runs one of the rays at a time, over and over.
template <class Rays, class F>
void forEachRay(benchmark::State& state, const Rays& rays, F&& trace) {
  benchmark::DoNotOptimize(&scene());  // is built before the clock starts
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(trace(rays[i]));
    if (++i == rays.size()) i = 0;
  }
  state.SetItemsProcessed(state.iterations());
}

void closestHitInEmbree(benchmark::State& state, Order order) {
  forEachRay(state, raysFromAbove(order),
             [](const Ray& ray) { return scene().accelerator().intersect(ray).has_value(); });
}
BENCHMARK_CAPTURE(closestHitInEmbree, coherent, Order::Coherent);
BENCHMARK_CAPTURE(closestHitInEmbree, random, Order::Random);

void closestHitInScene(benchmark::State& state, Order order) {
  Stats stats;
  forEachRay(state, raysFromAbove(order), [&](const FootprintRay& ray) {
    const auto hit = scene().intersect(ray, stats);
    return hit ? hit->p.x : 0.f;
  });
}
BENCHMARK_CAPTURE(closestHitInScene, coherent, Order::Coherent);
BENCHMARK_CAPTURE(closestHitInScene, random, Order::Random);

void occlusionInEmbree(benchmark::State& state) {
  forEachRay(state, shadowRays(),
             [](const Ray& ray) { return scene().accelerator().occluded(ray); });
}
BENCHMARK(occlusionInEmbree);

void occlusionInScene(benchmark::State& state) {
  Stats stats;
  forEachRay(state, shadowRays(), [&](const Ray& ray) { return scene().isOccluded(ray, stats); });
}
BENCHMARK(occlusionInScene);

}  // namespace
}  // namespace brume::bench
