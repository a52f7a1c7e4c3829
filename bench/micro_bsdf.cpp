// SPDX-License-Identifier: Apache-2.0
// Materials at one surface point: making the lobes, evaluating and sampling them.
#include <benchmark/benchmark.h>

#include "core/rng.h"
#include "support/bsdf_checks.h"

namespace brume::bench {
namespace {

constexpr std::size_t kDirections = 1024;

/// Directions to the viewer and to the light, both above the surface.
std::vector<Vec3> directionsAbove(std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Vec3> directions(kDirections);
  for (Vec3& d : directions)
    d = test::fromPlane(
        test::localDirection(0.05f + 0.95f * rng.uniform(), 2 * kPi * rng.uniform()));
  return directions;
}

void materialEvaluate(benchmark::State& state, const char* name) {
  const auto material = test::make<Material>(name, {});
  const SurfaceInteraction at = test::planePoint();
  for (auto _ : state) {
    Bsdf bsdf;
    material->evaluate(at, bsdf);
    benchmark::DoNotOptimize(bsdf.lobeCount());
  }
}

void bsdfEvaluate(benchmark::State& state, const char* name) {
  Bsdf bsdf;
  const auto material = test::make<Material>(name, {});
  material->evaluate(test::planePoint(), bsdf);
  const std::vector<Vec3> wo = directionsAbove(1), wi = directionsAbove(2);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(bsdf.evaluate(wo[i], wi[i]).pdf);
    i = (i + 1) % kDirections;
  }
}

void bsdfSample(benchmark::State& state, const char* name) {
  Bsdf bsdf;
  const auto material = test::make<Material>(name, {});
  material->evaluate(test::planePoint(), bsdf);
  const std::vector<Vec3> wo = directionsAbove(3);
  Rng rng(4);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(bsdf.sample(wo[i], rng.uniform(), rng.uniform2()));
    i = (i + 1) % kDirections;
  }
}

#define BRUME_BENCH_MATERIAL(name)                  \
  BENCHMARK_CAPTURE(materialEvaluate, name, #name); \
  BENCHMARK_CAPTURE(bsdfEvaluate, name, #name);     \
  BENCHMARK_CAPTURE(bsdfSample, name, #name)
BRUME_BENCH_MATERIAL(matte);
BRUME_BENCH_MATERIAL(plastic);
BRUME_BENCH_MATERIAL(substrate);

}  // namespace
}  // namespace brume::bench
