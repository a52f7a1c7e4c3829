// SPDX-License-Identifier: Apache-2.0
#include "tools/bench_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "core/error.h"
#include "core/version.h"
#include "tools/image_metrics.h"
#include "tools/machine.h"

namespace brume {
namespace {

constexpr std::size_t kTargets = 4;
/// Errors that the baseline does not reach and others do, at most.
constexpr std::size_t kTargetsBeyond = 2;
constexpr std::size_t kAllTargets = 1000;

/// One entry with its errors.
struct Measured {
  const BenchEntry* entry = nullptr;
  std::vector<CurvePoint> points;
};

/// The seeds of one method and number of threads, averaged moment by moment.
struct Mean {
  std::string method;
  int threads = 0;
  std::vector<CurveSample> bySeconds, byCpu;
};

std::vector<Measured> measure(BenchedScene& benched, const Truth& truth) {
  std::vector<Measured> all;
  for (BenchEntry& entry : benched.entries) {
    Measured measured{&entry, {}};
    try {
      for (const BenchPoint& point : entry.points)
        measured.points.push_back(measurePoint(toRgbImage(readLayeredImage(point.image)), truth));
    } catch (const SceneError& error) {
      entry.failure = error.what();
      entry.points.clear();
      measured.points.clear();
    }
    all.push_back(std::move(measured));
  }
  return all;
}

std::vector<Mean> averageSeeds(const std::vector<Measured>& all) {
  std::vector<Mean> means;
  for (const Measured& first : all) {
    const auto isSame = [&](const BenchEntry& e) {
      return e.method == first.entry->method && e.threads == first.entry->threads;
    };
    const bool isKnown = std::any_of(means.begin(), means.end(), [&](const Mean& m) {
      return m.method == first.entry->method && m.threads == first.entry->threads;
    });
    if (isKnown || first.points.empty()) continue;
    std::vector<const Measured*> seeds;
    std::size_t count = first.points.size();
    for (const Measured& m : all)
      if (isSame(*m.entry) && !m.points.empty()) {
        seeds.push_back(&m);
        count = std::min(count, m.points.size());
      }
    Mean mean{first.entry->method, first.entry->threads, {}, {}};
    const double n = static_cast<double>(seeds.size());
    for (std::size_t i = 0; i < count; ++i) {
      double seconds = 0, cpu = 0, error = 0;
      for (const Measured* m : seeds) {
        seconds += m->entry->points[i].seconds / n;
        cpu += m->entry->points[i].cpuSeconds / n;
        error += m->points[i].relMse / n;
      }
      mean.bySeconds.push_back({seconds, error});
      if (cpu > 0) mean.byCpu.push_back({cpu, error});
    }
    means.push_back(std::move(mean));
  }
  return means;
}

/// The baseline with as many threads, or with any number.
const Mean* baselineFor(const std::vector<Mean>& means, const std::string& name, int threads) {
  const Mean* any = nullptr;
  for (const Mean& mean : means)
    if (mean.method == name) {
      if (mean.threads == threads) return &mean;
      if (!any) any = &mean;
    }
  return any;
}

Json optionalJson(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

/// Errors for the table: those that the baseline reaches and a few below; without a baseline the
/// smallest that anything reaches. Falling.
std::vector<double> targetsFor(const std::vector<Mean>& means, const Mean* baseline) {
  std::vector<double> targets;
  if (baseline) targets = targetsOf(baseline->bySeconds, kTargets);
  std::set<double, std::greater<>> all;
  for (const Mean& mean : means)
    for (const double target : targetsOf(mean.bySeconds, kAllTargets)) all.insert(target);
  if (targets.empty()) {
    targets.assign(all.begin(), all.end());
    if (targets.size() > kTargets) targets.erase(targets.begin(), targets.end() - kTargets);
    return targets;
  }
  const auto beyond = all.upper_bound(targets.back());
  for (auto it = beyond; it != all.end() && targets.size() < kTargets + kTargetsBeyond; ++it)
    targets.push_back(*it);
  return targets;
}

/// How many times longer the baseline takes to the target: a value, or a lower bound where it never
/// gets there ("at least").
void addRatio(const std::vector<CurveSample>* baseline, std::optional<double> own, double target,
              const std::string& key, Json& row) {
  row[key] = Json();
  if (!baseline || baseline->empty() || !own) return;
  if (const auto base = reach(*baseline, target))
    row[key] = *base / *own;
  else if (baseline->back().x > *own)
    row["at least " + key] = baseline->back().x / *own;
}

/// Time to each error, and how many times faster than the baseline.
Json timesToError(const std::vector<Mean>& means, const std::string& baseline) {
  Json list = Json::array();
  if (means.empty()) return list;
  const std::vector<double> targets =
      targetsFor(means, baselineFor(means, baseline, means.front().threads));
  for (const Mean& mean : means) {
    const Mean* base = baselineFor(means, baseline, mean.threads);
    for (const double target : targets) {
      const auto seconds = reach(mean.bySeconds, target), cpu = reach(mean.byCpu, target);
      Json row;
      row["method"] = mean.method;
      row["threads"] = mean.threads;
      row["relmse"] = target;
      row["seconds"] = optionalJson(seconds);
      row["cpu seconds"] = optionalJson(cpu);
      addRatio(base ? &base->bySeconds : nullptr, seconds, target, "times faster", row);
      addRatio(base ? &base->byCpu : nullptr, cpu, target, "times less processor", row);
      list.push_back(std::move(row));
    }
  }
  return list;
}

Json curveJson(const Measured& measured) {
  const BenchEntry& entry = *measured.entry;
  Json json;
  json["method"] = entry.method;
  json["threads"] = entry.threads;
  json["seed"] = entry.seed;
  if (!entry.failure.empty()) json["failure"] = entry.failure;
  json["setup seconds"] = entry.setupSeconds;
  json["peak memory"] = entry.peakMemory;
  Json& points = json["points"] = Json::array();
  for (std::size_t i = 0; i < measured.points.size(); ++i) {
    const BenchPoint& at = entry.points[i];
    const CurvePoint& error = measured.points[i];
    Json point;
    point["seconds"] = at.seconds;
    if (at.cpuSeconds > 0) point["cpu seconds"] = at.cpuSeconds;
    if (at.samples > 0) point["samples"] = at.samples;
    point["relmse"] = error.relMse;
    point["relative error"] = error.relative;
    if (at.estimatedError) point["estimated error"] = *at.estimatedError;
    point["flip"] = error.flip;
    point["mean ratio"] = error.meanRatio;
    if (!at.counters.empty()) point["counters"] = at.counters;
    points.push_back(std::move(point));
  }
  return json;
}

Json machineJson() {
  const Machine machine = thisMachine();
  Json json;
  json["processor"] = machine.processor;
  json["processors"] = machine.processors;
  json["memory"] = machine.memory;
  json["system"] = machine.system;
  json["load"] = machine.load;
  return json;
}

}  // namespace

Json benchResults(const BenchConfig& config, std::vector<BenchedScene>& scenes) {
  Json json;
  json["title"] = config.title;
  json["brume"] = version();
  json["date"] = utcTime();
  json["machine"] = machineJson();
  json["baseline"] = config.baseline;
  Json& list = json["scenes"] = Json::array();
  for (BenchedScene& benched : scenes) {
    if (!benched.failure.empty()) {
      list.push_back({{"name", benched.scene->name},
                      {"failure", benched.failure},
                      {"curves", Json::array()},
                      {"times to error", Json::array()}});
      continue;
    }
    const Truth truth = readTruth(benched.referenceFile);
    const std::vector<Measured> measured = measure(benched, truth);
    Json scene;
    scene["name"] = benched.scene->name;
    scene["resolution"] = {truth.image.width, truth.image.height};
    scene["reference noise"] = truth.relMseNoise();
    scene["reference noise is known"] = !truth.variance.empty();
    Json& curves = scene["curves"] = Json::array();
    for (const Measured& m : measured) curves.push_back(curveJson(m));
    scene["times to error"] = timesToError(averageSeeds(measured), config.baseline);
    list.push_back(std::move(scene));
  }
  return json;
}

}  // namespace brume
