// SPDX-License-Identifier: Apache-2.0
#include "tools/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/error.h"
#include "tools/bench_config.h"
#include "tools/bench_entry.h"
#include "tools/bench_report.h"
#include "tools/text_file.h"

namespace brume {
namespace {

/// Renders what is missing of one scene; false when stopped.
bool renderScene(const BenchConfig& config, BenchRunner& runner, BenchedScene& benched) {
  const BenchScene& scene = *benched.scene;
  benched.referenceFile = runner.reference(scene);
  if (benched.referenceFile.empty()) return false;
  for (const BenchMethod& method : config.methods) {
    if (!config.runs(scene, method)) continue;
    for (const int threads : config.threads)
      for (const std::uint64_t seed : config.seeds) {
        auto entry = runner.entry(scene, method, threads, seed);
        if (!entry) return false;
        benched.entries.push_back(std::move(*entry));
      }
  }
  return true;
}

}  // namespace

BenchOutcome bench(const BenchOptions& options, const std::atomic<bool>& stop,
                   const std::function<void(const std::string&)>& say) {
  const BenchConfig config = readBenchConfig(options.file);
  const std::filesystem::path folder =
      options.output.empty()
          ? std::filesystem::path(options.file).replace_extension("").string() + "-results"
          : options.output;
  // What can be wrong is found before anything is rendered.
  const std::vector<BenchEntry> foreign = config.foreign.empty()
                                              ? std::vector<BenchEntry>{}
                                              : readForeignEntries(config.foreign, config);

  BenchRunner runner(config, folder.string(), stop, say);
  std::vector<BenchedScene> scenes;
  for (const BenchScene& scene : config.scenes) {
    BenchedScene& benched = scenes.emplace_back();
    benched.scene = &scene;
    if (!renderScene(config, runner, benched)) return BenchOutcome::Interrupted;
    for (const BenchEntry& entry : foreign)
      if (entry.scene == scene.name) benched.entries.push_back(entry);
  }

  std::filesystem::create_directories(folder);
  const Json results = benchResults(config, scenes);
  writeTextFile((folder / "results.json").string(), jsonText(results));
  writeTextFile((folder / "index.html").string(), benchPage(results, scenes));
  say(fmt::format("wrote {} and results.json", (folder / "index.html").string()));
  const bool isFaulty = std::any_of(scenes.begin(), scenes.end(), [](const BenchedScene& s) {
    return std::any_of(s.entries.begin(), s.entries.end(),
                       [](const BenchEntry& e) { return !e.failure.empty(); });
  });
  return isFaulty ? BenchOutcome::SomeFailed : BenchOutcome::Done;
}

}  // namespace brume
