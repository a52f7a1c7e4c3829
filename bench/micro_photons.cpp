// SPDX-License-Identifier: Apache-2.0
// Photon maps: building, k nearest, all within a radius, photons along beams; nanoflann for
// comparison where it is installed (Debian: libnanoflann-dev).
#include <benchmark/benchmark.h>

#include "accelerators/photon_bvh.h"
#include "core/rng.h"
#include "transport/kernels.h"

#if __has_include(<nanoflann.hpp>)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include <nanoflann.hpp>
#pragma GCC diagnostic pop
#define BRUME_BENCH_NANOFLANN 1
#endif

namespace brume::bench {
namespace {

constexpr std::size_t kPhotons = 400'000;

/// Uniform in the unit cube.
const std::vector<Vec3>& points() {
  static const std::vector<Vec3> result = [] {
    Rng rng(1);
    std::vector<Vec3> p(kPhotons);
    for (Vec3& x : p) x = Vec3(rng.uniform(), rng.uniform(), rng.uniform());
    return p;
  }();
  return result;
}

const PhotonKdTree& tree() {
  static const PhotonKdTree result{std::span<const Vec3>(points())};
  return result;
}

/// A march along rays, as a volume integrator asks: neighbours are near each other.
Vec3 marchPoint(std::size_t i) {
  const std::size_t step = i % 32, ray = i / 32 % 4096;
  return Vec3((static_cast<float>(ray % 64) + 0.5f) / 64,
              (static_cast<float>(ray / 64) + 0.5f) / 64, (static_cast<float>(step) + 0.5f) / 32);
}

void buildPhotonTree(benchmark::State& state) {
  for (auto _ : state) {
    const PhotonKdTree built{std::span<const Vec3>(points())};
    benchmark::DoNotOptimize(built.view().top);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kPhotons));
}
BENCHMARK(buildPhotonTree)->Unit(benchmark::kMillisecond);

void buildAdaptiveRadii(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(adaptiveRadii2(tree(), 50).data());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kPhotons));
}
BENCHMARK(buildAdaptiveRadii)->Unit(benchmark::kMillisecond);

/// The hierarchy over the tree that is there, with a radius for each photon.
void buildPhotonBvh(benchmark::State& state) {
  const std::vector<float> radii2 = adaptiveRadii2(tree(), 10);
  for (auto _ : state) benchmark::DoNotOptimize(PhotonBvh(tree(), radii2).memoryBytes());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kPhotons));
}
BENCHMARK(buildPhotonBvh)->Unit(benchmark::kMillisecond);

void nearestPhotons(benchmark::State& state) {
  std::vector<Neighbour> found(static_cast<std::size_t>(state.range(0)));
  std::size_t i = 0;
  benchmark::DoNotOptimize(tree().size());
  for (auto _ : state) benchmark::DoNotOptimize(tree().nearest(marchPoint(i++), found));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(nearestPhotons)->Arg(10)->Arg(50)->Arg(100)->Arg(500);

/// The radius of the ball that holds so many.
float radiusFor(benchmark::State& state) {
  return std::cbrt(static_cast<float>(state.range(0)) * 3 / (4 * kPi * float{kPhotons}));
}

void photonsWithin(benchmark::State& state) {
  const float radius = radiusFor(state);
  std::size_t i = 0, pairs = 0;
  benchmark::DoNotOptimize(tree().size());
  for (auto _ : state) {
    float sum = 0;
    tree().forEachWithin(marchPoint(i++), sqr(radius), [&](std::uint32_t, float d2) {
      sum += d2;
      ++pairs;
    });
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["pairs/s"] =
      benchmark::Counter(static_cast<double>(pairs), benchmark::Counter::kIsRate);
}
BENCHMARK(photonsWithin)->Arg(10)->Arg(50)->Arg(100)->Arg(500);

/// Camera rays in tiles of 8 x 8 pixels of an image of 256 x 256.
BeamQuery cameraBeam(std::size_t i) {
  const std::size_t inTile = i % 64, tile = i / 64 % 1024;
  const Vec2 pixel(static_cast<float>(tile % 32 * 8 + inTile % 8) + 0.5f,
                   static_cast<float>(tile / 32 * 8 + inTile / 8) + 0.5f);
  const Vec3 o(0.5f, 0.5f, -1.5f);
  return {o, normalize(Vec3(pixel / 256.f, 1) - o), {0, kInfinity}};
}

/// Each pair is weighted by its kernel and a power: what a beam radiance estimate does at least.
void photonsOfBeam(benchmark::State& state, const PhotonBvh& bvh) {
  const std::vector<float> power(kPhotons, 1);
  std::size_t i = 0, pairs = 0;
  for (auto _ : state) {
    float sum = 0;
    bvh.forEachInBeam(cameraBeam(i++), [&](std::uint32_t photon, const BeamFoot<float>& foot) {
      sum += power[photon] * DiscKernel(bvh.radius2(photon))(foot.d2);
      ++pairs;
    });
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["pairs/s"] =
      benchmark::Counter(static_cast<double>(pairs), benchmark::Counter::kIsRate);
}
void photonsOfBeamOneRadius(benchmark::State& state) {
  photonsOfBeam(state, PhotonBvh(tree(), 1e-3f * static_cast<float>(state.range(0))));
}
BENCHMARK(photonsOfBeamOneRadius)->Arg(5)->Arg(10)->Arg(20)->Arg(40);
void photonsOfBeamAdaptiveRadii(benchmark::State& state) {
  photonsOfBeam(
      state, PhotonBvh(tree(), adaptiveRadii2(tree(), static_cast<std::size_t>(state.range(0)))));
}
BENCHMARK(photonsOfBeamAdaptiveRadii)->Arg(10)->Arg(50);

#ifdef BRUME_BENCH_NANOFLANN
struct Cloud {
  std::size_t kdtree_get_point_count() const { return kPhotons; }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points()[i][static_cast<int>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using Nanoflann = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>,
                                                      Cloud, 3, std::uint32_t>;
const Nanoflann& nanoflannTree() {
  static const Cloud cloud;
  static const Nanoflann result(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  return result;
}

void buildNanoflann(benchmark::State& state) {
  const Cloud cloud;
  for (auto _ : state) {
    const Nanoflann built(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(10));
    benchmark::DoNotOptimize(&built);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kPhotons));
}
BENCHMARK(buildNanoflann)->Unit(benchmark::kMillisecond);

void nearestByNanoflann(benchmark::State& state) {
  const auto k = static_cast<std::size_t>(state.range(0));
  std::vector<std::uint32_t> indices(k);
  std::vector<float> distances2(k);
  std::size_t i = 0;
  benchmark::DoNotOptimize(&nanoflannTree());
  for (auto _ : state) {
    const Vec3 p = marchPoint(i++);
    benchmark::DoNotOptimize(nanoflannTree().knnSearch(&p.x, k, indices.data(), distances2.data()));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(nearestByNanoflann)->Arg(10)->Arg(50)->Arg(100)->Arg(500);

void withinByNanoflann(benchmark::State& state) {
  const float radius = radiusFor(state);
  std::vector<std::pair<std::uint32_t, float>> found;
  nanoflann::SearchParams search;
  search.sorted = false;
  std::size_t i = 0;
  benchmark::DoNotOptimize(&nanoflannTree());
  for (auto _ : state) {
    const Vec3 p = marchPoint(i++);
    float sum = 0;
    nanoflannTree().radiusSearch(&p.x, sqr(radius), found, search);
    for (const auto& pair : found) sum += pair.second;
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(withinByNanoflann)->Arg(10)->Arg(50)->Arg(100)->Arg(500);
#endif

}  // namespace
}  // namespace brume::bench
