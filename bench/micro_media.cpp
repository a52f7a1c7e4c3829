// SPDX-License-Identifier: Apache-2.0
// Media along random rays through a unit box: optical depth, free flight, phase functions.
#include <benchmark/benchmark.h>

#include "core/medium_along_ray.h"
#include "support/make_plugin.h"
#include "support/volumes.h"
#include "volumes/phase_functions.h"

namespace brume::bench {
namespace {

using VolumePtr = std::unique_ptr<Volume>;

test::MediumSpec spec() {
  test::MediumSpec s;
  s.sigma_a = Rgb(0.3f, 0.5f, 0.8f);
  s.sigma_s = Rgb(2, 1.5f, 1);
  return s;
}
VolumePtr homogeneous() { return test::makeHomogeneous(spec()); }
VolumePtr exponential() { return test::makeExponential(spec(), 1, 3); }
VolumePtr grid64() {
  Rng rng(3);
  return test::makeGrid(spec(), 64, 64, 64, test::randomDensities(64 * 64 * 64, rng));
}
/// Procedural: tracked by tentative collisions.
VolumePtr cloud() {
  return test::make<Volume>(
      "cloud", {test::color("sigma_a", {.3f, .5f, .8f}), test::color("sigma_s", {2, 1.5f, 1}),
                test::points("p0", {Vec3(0)}), test::points("p1", {Vec3(1)})});
}

/// The first three in one place, as the scene adds up what overlaps.
VolumePtr overlap() {
  static const VolumePtr parts[] = {homogeneous(), exponential(), grid64()};
  return makeAggregateVolume({parts[0].get(), parts[1].get(), parts[2].get()});
}

struct Crossing {
  Ray ray;
  Interval range;
};

/// Rays from outside through random points of the box.
std::vector<Crossing> crossings(const Volume& volume) {
  std::vector<Crossing> result;
  Rng rng(4);
  while (result.size() < 4096) {
    const Vec3 through(rng.uniform(), rng.uniform(), rng.uniform());
    const Vec3 d = test::randomDirection(rng);
    const Ray ray(through - 2.f * d, d);
    if (const auto range = volume.intersect(ray)) result.push_back({ray, *range});
  }
  return result;
}

/// Calls f(crossing, random number) for one crossing after another.
template <class F>
void forEachCrossing(benchmark::State& state, const Volume& volume, F&& f) {
  const std::vector<Crossing> all = crossings(volume);
  Rng rng(5);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(f(all[i], rng.uniformDouble()));
    i = (i + 1) % all.size();
  }
  state.SetItemsProcessed(state.iterations());
}

void opticalDepth(benchmark::State& state, VolumePtr (*make)()) {
  const VolumePtr volume = make();
  forEachCrossing(state, *volume,
                  [&](const Crossing& c, double) { return volume->opticalDepth(c.ray, c.range); });
}
BENCHMARK_CAPTURE(opticalDepth, homogeneous, homogeneous);
BENCHMARK_CAPTURE(opticalDepth, exponential, exponential);
BENCHMARK_CAPTURE(opticalDepth, grid64, grid64);
BENCHMARK_CAPTURE(opticalDepth, overlap, overlap);

void mediumAlongRay(benchmark::State& state, VolumePtr (*make)()) {
  const VolumePtr volume = make();
  MediumAlongRay medium;
  forEachCrossing(state, *volume, [&](const Crossing& c, double) {
    medium.assign(*volume, c.ray, c.range);
    return medium.opticalDepth();
  });
}
BENCHMARK_CAPTURE(mediumAlongRay, homogeneous, homogeneous);
BENCHMARK_CAPTURE(mediumAlongRay, exponential, exponential);
BENCHMARK_CAPTURE(mediumAlongRay, grid64, grid64);
BENCHMARK_CAPTURE(mediumAlongRay, overlap, overlap);

/// The distance to a collision in a medium that is looked up already.
void invertMediumAlongRay(benchmark::State& state, VolumePtr (*make)()) {
  const VolumePtr volume = make();
  std::vector<MediumAlongRay> media;
  for (const Crossing& c : crossings(*volume)) {
    media.emplace_back(*volume, c.ray, c.range);
    if (media.size() == 64) break;
  }
  Rng rng(6);
  std::size_t i = 0;
  for (auto _ : state) {
    const MediumAlongRay& medium = media[i];
    const double depth = rng.uniformDouble() * double{medium.opticalDepth().g};
    benchmark::DoNotOptimize(medium.invert(1, depth));
    i = (i + 1) % media.size();
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK_CAPTURE(invertMediumAlongRay, homogeneous, homogeneous);
BENCHMARK_CAPTURE(invertMediumAlongRay, exponential, exponential);
BENCHMARK_CAPTURE(invertMediumAlongRay, grid64, grid64);
BENCHMARK_CAPTURE(invertMediumAlongRay, overlap, overlap);

/// Free flight: look the medium up and find where the depth -log(1 - u) is reached.
void freeFlight(benchmark::State& state, VolumePtr (*make)()) {
  const VolumePtr volume = make();
  MediumAlongRay medium;
  forEachCrossing(state, *volume, [&](const Crossing& c, double u) {
    medium.assign(*volume, c.ray, c.range);
    return medium.invert(1, -std::log1p(-u));
  });
}
BENCHMARK_CAPTURE(freeFlight, homogeneous, homogeneous);
BENCHMARK_CAPTURE(freeFlight, exponential, exponential);
BENCHMARK_CAPTURE(freeFlight, grid64, grid64);
BENCHMARK_CAPTURE(freeFlight, overlap, overlap);
BENCHMARK_CAPTURE(freeFlight, cloud, cloud);

using PhasePtr = std::unique_ptr<PhaseFunction>;
PhasePtr henyeyGreenstein() { return makeHenyeyGreensteinPhase(0.8f); }
PhasePtr mixture() {
  std::vector<PhasePtr> lobes;
  lobes.push_back(makeHenyeyGreensteinPhase(0.8f));
  lobes.push_back(makeHenyeyGreensteinPhase(-0.4f));
  lobes.push_back(makeIsotropicPhase());
  return makeMixturePhase(std::move(lobes), {0.6f, 0.3f, 0.1f});
}
PhasePtr schlick() { return makeSchlickPhase(0.8f); }

void phaseValue(benchmark::State& state, PhasePtr (*make)()) {
  const PhasePtr phase = make();
  Rng rng(7);
  std::vector<Vec3> directions(1025);
  for (Vec3& d : directions) d = test::randomDirection(rng);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(phase->p(directions[i], directions[i + 1]));
    i = (i + 1) % 1024;
  }
}
void phaseSample(benchmark::State& state, PhasePtr (*make)()) {
  const PhasePtr phase = make();
  Rng rng(8);
  const Vec3 wo = test::randomDirection(rng);
  for (auto _ : state)
    benchmark::DoNotOptimize(phase->sample(wo, rng.uniform(), rng.uniform2()).wi);
}
#define BRUME_BENCH_PHASE(name, make)        \
  BENCHMARK_CAPTURE(phaseValue, name, make); \
  BENCHMARK_CAPTURE(phaseSample, name, make)
BRUME_BENCH_PHASE(isotropic, makeIsotropicPhase);
BRUME_BENCH_PHASE(rayleigh, makeRayleighPhase);
BRUME_BENCH_PHASE(henyeygreenstein, henyeyGreenstein);
BRUME_BENCH_PHASE(schlick, schlick);
BRUME_BENCH_PHASE(miehazy, makeMieHazyPhase);
BRUME_BENCH_PHASE(miemurky, makeMieMurkyPhase);
BRUME_BENCH_PHASE(mixture, mixture);

}  // namespace
}  // namespace brume::bench
