// SPDX-License-Identifier: Apache-2.0
// Bytes of scene text that are turned into meshes per second.
#include <benchmark/benchmark.h>

#include "core/parse/scene_description.h"
#include "micro_wavy_grid.h"

namespace brume::bench {

namespace {

void parseMesh(benchmark::State& state) {
  const std::string text = wavyGridScene(static_cast<std::size_t>(state.range(0)) * 1'000'000);
  Log::Options quiet;
  quiet.verbosity = Verbosity::Quiet;
  Log log(quiet);
  for (auto _ : state)
    parseSceneText(text, "mesh", ".", {}, log, [](const SceneDescription& description) {
      benchmark::DoNotOptimize(description.world.shapes.data());
    });
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(text.size()));
}
BENCHMARK(parseMesh)->ArgName("MB")->Arg(20)->Arg(100)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace brume::bench
