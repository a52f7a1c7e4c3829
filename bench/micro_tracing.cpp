// SPDX-License-Identifier: Apache-2.0
// Light paths in a box of fog: the cost of one path and of one stored photon, on one thread.
#include <benchmark/benchmark.h>

#include "core/parallel.h"
#include "renderers/render_job.h"
#include "transport/photon_tracer.h"

namespace brume::bench {
namespace {

/// A closed grey box, 4 wide, with a point light and the medium in it; mean free path 1.
std::unique_ptr<RenderJob> fogBox(const std::string& medium) {
  const std::string text = R"(LookAt 0 0 -1.9  0 0 0  0 1 0
Camera "perspective"
WorldBegin
LightSource "point" "point from" [0 1.5 0] "color I" [1 1 1]
)" + medium + R"(
  "point p0" [-2 -2 -2] "point p1" [2 2 2] "color sigma_a" [.1 .1 .1] "color sigma_s" [.9 .9 .9]
Material "matte" "color Kd" [.5 .5 .5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3  4 5 6 4 6 7  0 1 5 0 5 4  1 2 6 1 6 5  2 3 7 2 7 6  3 0 4 3 4 7]
  "point P" [-2 -2 -2  2 -2 -2  2 -2 2  -2 -2 2  -2 2 -2  2 2 -2  2 2 2  -2 2 2]
WorldEnd
)";
  Log log({Verbosity::Quiet, false, false});
  std::unique_ptr<RenderJob> job;
  parseSceneText(text, "fog box", ".", {}, log, [&](SceneDescription description) {
    job = std::make_unique<RenderJob>(std::move(description), RenderSettings{}, log);
  });
  return job;
}

std::string grid() {
  constexpr int kSide = 16;
  std::string text =
      "Volume \"volumegrid\" \"integer nx\" 16 \"integer ny\" 16 \"integer nz\" 16 "
      "\"float density\" [";
  for (int i = 0; i < kSide * kSide * kSide; ++i) text += i % 3 == 0 ? "2 " : ".5 ";
  return text + "]";
}

/// Stores every photon in media and on surfaces.
void tracePhotons(benchmark::State& state, const std::string& medium) {
  setThreadCount(1);
  const auto job = fogBox(medium);
  PhotonRequest request;
  request.wanted = kVolumePhotons | kSurfacePhotons;
  const PhotonTracer tracer(job->scene(), request);
  constexpr std::uint64_t kPaths = 4096;
  PathsPerClass paths;
  paths.fill(kPaths);
  const std::atomic<bool> stop{false};
  std::uint64_t pass = 0, photons = 0;
  for (auto _ : state) {
    Stats stats;
    const PhotonSet set = tracer.trace(1, pass++, paths, stop, stats);
    photons += set.photons.size();
    benchmark::DoNotOptimize(set.photons.data());
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(photons));
  state.counters["paths/s"] =
      benchmark::Counter(static_cast<double>(kPaths) * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate);
}
BENCHMARK_CAPTURE(tracePhotons, homogeneous, "Volume \"homogeneous\"")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(tracePhotons, grid16, grid())->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace brume::bench
