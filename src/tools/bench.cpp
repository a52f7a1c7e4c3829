// SPDX-License-Identifier: Apache-2.0
#include "tools/bench.h"

#include <fmt/format.h>

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
  BenchRunner::Reference reference = runner.reference(scene);
  if (reference.file.empty() && reference.failure.empty()) return false;
  benched.referenceFile = std::move(reference.file);
  benched.failure = std::move(reference.failure);
  benched.isFault = reference.isFault;
  if (!benched.failure.empty()) return true;
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

/// How many references and renders failed, and how many of them by brume's fault.
struct Failures {
  std::size_t all = 0, faults = 0;
  void count(const std::string& failure, bool isFault) {
    all += failure.empty() ? 0 : 1;
    faults += isFault ? 1 : 0;
  }
};
Failures countFailures(const std::vector<BenchedScene>& scenes) {
  Failures failures;
  for (const BenchedScene& scene : scenes) {
    failures.count(scene.failure, scene.isFault);
    for (const BenchEntry& entry : scene.entries) failures.count(entry.failure, entry.isFault);
  }
  return failures;
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
  for (const BenchScene& scene : config.scenes)
    if (!scene.reference.file.empty()) readTruth(scene.reference.file);

  BenchRunner runner(config, folder.string(), stop, say);
  std::vector<BenchedScene> scenes;
  for (const BenchScene& scene : config.scenes) {
    BenchedScene& benched = scenes.emplace_back();
    benched.scene = &scene;
    if (!renderScene(config, runner, benched)) {
      say(fmt::format("interrupted: what is finished is kept in {}; the same call goes on there",
                      folder.string()));
      return BenchOutcome::Interrupted;
    }
    for (const BenchEntry& entry : foreign)
      if (entry.scene == scene.name && benched.failure.empty()) benched.entries.push_back(entry);
  }

  std::filesystem::create_directories(folder);
  const Json results = benchResults(config, scenes);
  writeTextFile((folder / "results.json").string(), jsonText(results));
  writeTextFile((folder / "index.html").string(), benchPage(results, scenes));
  say(fmt::format("wrote {} and results.json", (folder / "index.html").string()));
  const Failures failures = countFailures(scenes);
  if (failures.all == 0) return BenchOutcome::Done;
  say(fmt::format("FAILED   {} of the renders; the same call tries them again", failures.all));
  return failures.faults > 0 ? BenchOutcome::SomeFaulty : BenchOutcome::SomeFailed;
}

}  // namespace brume
