// SPDX-License-Identifier: Apache-2.0
// Camera beams against photons: building the lookups, finding the pairs by each of them,
// evaluating. brume_beams has larger cases and how all this grows.
#include <benchmark/benchmark.h>

#include "accelerators/beam_quadtree.h"
#include "accelerators/beam_raster.h"
#include "core/parallel.h"
#include "core/rng.h"
#include "core/sampling.h"
#include "transport/beam_gather.h"

namespace brume::bench {
namespace {

constexpr int kSide = 128;  // beams along each side of the image
constexpr float kNear = 2, kFar = 3;
const Rgb kSigmaT(0.4f, 0.5f, 0.6f);

/// Jittered rays of a pinhole through (-1, -1, 1) .. (1, 1, 1); radius: about 4 pixels.
const std::vector<Beam>& beams() {
  static const std::vector<Beam> result = [] {
    setThreadCount(1);
    std::vector<Beam> all;
    Rng rng(1);
    for (std::uint32_t pixel = 0; pixel < kSide * kSide; ++pixel) {
      const Vec2 u = rng.uniform2();
      const float x = static_cast<float>(pixel % kSide) + u.x,
                  y = static_cast<float>(pixel / kSide) + u.y;
      const Vec3 d = normalize(Vec3(2 * x / kSide - 1, 2 * y / kSide - 1, 1));
      all.push_back({Vec3(0), kNear, d, kFar, 13.f / kSide, pixel});
    }
    return all;
  }();
  return result;
}

/// Uniform over the medium's directions and depths, row by row of the image, as sorted photons are.
std::vector<BeamPhoton> photons(std::size_t count) {
  std::vector<BeamPhoton> all(count);
  Rng rng(2);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec2 u(rng.uniform(),
                 (static_cast<float>(i) + rng.uniform()) / static_cast<float>(count));
    const float t = lerp(kNear, kFar, rng.uniform());
    all[i].p = t * normalize(Vec3(2 * u.x - 1, 2 * u.y - 1, 1));
    all[i].w = sampleUniformSphere(rng.uniform2());
    all[i].power = Rgb(1, 0.8f, 0.6f);
    all[i].g = 0.6f;
  }
  return all;
}

template <class Lookup>
Lookup build() {
  if constexpr (std::is_same_v<Lookup, BeamQuadtree>)
    return BeamQuadtree(beams(), {kSide, kSide});
  else
    return Lookup(beams());
}

template <class Lookup>
void buildBeamLookup(benchmark::State& state) {
  benchmark::DoNotOptimize(beams().data());
  for (auto _ : state) benchmark::DoNotOptimize(build<Lookup>().memoryBytes());
  state.SetItemsProcessed(state.iterations() * kSide * kSide);
}
BENCHMARK_TEMPLATE(buildBeamLookup, BeamQuadtree)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(buildBeamLookup, RasterBeams)->Unit(benchmark::kMillisecond);

/// The pairs alone, as fast as the lookup hands them out; items are pairs.
template <class Lookup>
void findBeamPairs(benchmark::State& state) {
  const auto all = photons(static_cast<std::size_t>(state.range(0)));
  const PhotonPositions positions{std::span(all), &BeamPhoton::p};
  const Lookup lookup = build<Lookup>();
  const auto count = [](void* n, const BeamPairs& pairs) {
    *static_cast<std::uint64_t*>(n) += pairs.slots.size();
  };
  std::uint64_t pairs = 0;
  for (auto _ : state) lookup.findPairs(positions, count, &pairs);
  state.SetItemsProcessed(static_cast<std::int64_t>(pairs));
}
BENCHMARK_TEMPLATE(findBeamPairs, LinearBeams)->Arg(1000)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(findBeamPairs, RasterBeams)->Arg(1000)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(findBeamPairs, BeamQuadtree)->Arg(1000)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(findBeamPairs, RasterBeams)->Arg(20000)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(findBeamPairs, BeamQuadtree)->Arg(20000)->Unit(benchmark::kMillisecond);

/// Finding and evaluating: transmittance, phase function, kernel; items are pairs.
void evaluateBeamPairs(benchmark::State& state) {
  const auto all = photons(20000);
  const BeamQuadtree tree = build<BeamQuadtree>();
  std::vector<BeamSum> sums(beams().size());
  for (auto _ : state) gatherHomogeneous(tree, all, kSigmaT, sums);
  std::uint64_t pairs = 0;
  for (const BeamSum& sum : sums) pairs += sum.count;
  state.SetItemsProcessed(static_cast<std::int64_t>(pairs));
}
BENCHMARK(evaluateBeamPairs)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace brume::bench
