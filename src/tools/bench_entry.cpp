// SPDX-License-Identifier: Apache-2.0
#include "tools/bench_entry.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/error.h"
#include "core/io/file_bytes.h"
#include "core/parallel.h"
#include "core/rng.h"
#include "core/version.h"
#include "tools/child_process.h"
#include "tools/json_object.h"
#include "tools/json_report.h"
#include "tools/render_frame.h"
#include "tools/text_file.h"

namespace brume {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxSceneBytes = std::uint64_t{1} << 40;

/// A name as part of a file's.
std::string fileName(const std::string& name) {
  std::string result;
  for (const char c : name)
    result += std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '.' ? c : '_';
  return result;
}

/// A number that differs between different texts: FNV-1a.
std::uint64_t hashText(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

/// What the render of a scene depends on. Files that the scene includes are not looked at.
std::string sceneKey(const BenchScene& scene) {
  const Bytes bytes = readFileBytes(scene.file, kMaxSceneBytes);
  const std::string text(bytes.begin(), bytes.end());
  const Vec2i size = scene.resolution.value_or(Vec2i{0});
  return fmt::format("{:x} {}x{} {}", hashText(text), size.x, size.y,
                     scene.samplesPerPixel.value_or(0));
}

RenderSettings settingsFor(const BenchScene& scene) {
  RenderSettings settings;
  settings.resolution = scene.resolution;
  settings.samplesPerPixel = scene.samplesPerPixel;
  settings.variance = true;
  return settings;
}

Json pointJson(const BenchPoint& point) {
  Json json;
  json["seconds"] = point.seconds;
  json["cpu seconds"] = point.cpuSeconds;
  json["samples"] = point.samples;
  json["image"] = point.image;
  if (point.estimatedError) json["estimated error"] = *point.estimatedError;
  json["counters"] = point.counters;
  return json;
}

/// Of a signal that was sent to the process of one render alone; one to all ends the benchmark, and
/// this is not told.
void refuseInterrupted(const RenderResult& result) {
  if (result.reason == StopReason::Interrupted)
    throw SceneError("interrupted by a signal to its process");
}

/// Writes the images and the times of one render into its folder; runs in the child.
class EntryRecorder {
 public:
  EntryRecorder(fs::path folder, std::string key)
      : folder_(std::move(folder)), key_(std::move(key)) {}

  void record(const BenchScene& scene, const RenderSettings& settings,
              const std::atomic<bool>& stop) {
    Log log({Verbosity::Quiet, false, false});
    cpuStart_ = processorSeconds();
    const RenderResult last = renderFrame(scene.file, settings, log, stop,
                                          [&](const RenderResult& soFar) { add(soFar); });
    refuseInterrupted(last);
    if (points_.empty() || points_.back()["samples"] != static_cast<double>(last.samples))
      add(last);
    Json json;
    json["key"] = key_;
    json["version"] = version();
    json["setup seconds"] = last.setupSeconds;
    json["points"] = points_;
    writeTextFile((folder_ / "entry.json").string(), jsonText(json));
  }

 private:
  void add(const RenderResult& soFar) {
    const double cpuBefore = processorSeconds();
    BenchPoint point;
    point.seconds = soFar.setupSeconds + soFar.seconds;
    point.cpuSeconds = cpuBefore - cpuStart_ - cpuInImages_;
    point.samples = static_cast<double>(soFar.samples);
    point.estimatedError = soFar.estimatedError;
    point.image = fmt::format("{:03}.exr", points_.size());
    for (std::size_t i = 0; i < static_cast<std::size_t>(Stat::Count); ++i)
      if (const auto n = soFar.stats[static_cast<Stat>(i)])
        point.counters[std::string(statName(static_cast<Stat>(i)))] = static_cast<double>(n);
    writeImage((folder_ / point.image).string(), soFar.image);
    points_.push_back(pointJson(point));
    cpuInImages_ += processorSeconds() - cpuBefore;
  }

  fs::path folder_;
  std::string key_;
  Json points_ = Json::array();
  double cpuStart_ = 0, cpuInImages_ = 0;
};

void readPoints(const Json& json, const fs::path& folder, BenchEntry& entry) {
  entry.version = json.value("version", "");
  entry.setupSeconds = json.value("setup seconds", 0.);
  entry.peakMemory = json.value("peak memory", std::uint64_t{0});
  for (const Json& point : json.at("points")) {
    BenchPoint p;
    p.seconds = point.at("seconds");
    p.cpuSeconds = point.at("cpu seconds");
    p.samples = point.at("samples");
    if (point.contains("estimated error")) p.estimatedError = point.at("estimated error");
    p.image = (folder / point.at("image").get<std::string>()).string();
    if (!fs::exists(p.image)) throw SceneError(fmt::format("'{}' is not there", p.image));
    p.counters = point.at("counters").get<std::map<std::string, double>>();
    entry.points.push_back(std::move(p));
  }
}

/// The points of a finished entry, if that is what the folder holds. One that is not as it was
/// written counts as not finished.
bool readEntry(const fs::path& folder, const std::string& key, BenchEntry& entry) {
  const fs::path file = folder / "entry.json";
  if (!fs::exists(file)) return false;
  BenchEntry found = entry;
  try {
    const Json json = readJsonFile(file.string());
    if (json.value("key", "") != key) return false;
    readPoints(json, folder, found);
  } catch (const SceneError&) {
    return false;
  } catch (const Json::exception&) {
    return false;
  }
  entry = std::move(found);
  return true;
}

void makeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw SceneError(
        fmt::format("cannot make the folder '{}': {}", folder.string(), error.message()));
}

}  // namespace

std::optional<BenchEntry> BenchRunner::entry(const BenchScene& scene, const BenchMethod& method,
                                             int threads, std::uint64_t seed) {
  BenchEntry entry;
  entry.scene = scene.name;
  entry.method = method.name;
  entry.threads = threads;
  entry.seed = seed;
  RenderSettings settings = settingsFor(scene);
  settings.seed = seed;
  settings.integrators = method.integrators;
  settings.passes = method.passes ? method.passes : config_.passes;
  settings.maxSeconds = method.seconds ? method.seconds : config_.seconds;
  const std::string key = fmt::format(
      "{} | {} | {} {} | {} {} | {}", sceneKey(scene), fmt::join(method.integrators, " "),
      settings.passes.value_or(0), settings.maxSeconds.value_or(0), threads, seed, version());
  const fs::path folder =
      fs::path(folder_) / "entries" / fileName(scene.name) /
      fmt::format("{}-{:x}", fileName(method.name), hashText(method.name) & 0xffff) /
      fmt::format("threads{}-seed{}", threads, seed);
  const std::string name =
      fmt::format("{}, {}, {} threads, seed {}", scene.name, method.name, threads, seed);
  if (readEntry(folder, key, entry)) {
    say_(fmt::format("kept     {}", name));
    return entry;
  }

  // Anew, in a process of its own.
  makeFolder(folder);
  fs::remove(folder / "entry.json");
  const ChildOutcome outcome = runInChild([&] {
    setThreadCount(threads);
    EntryRecorder(folder, key).record(scene, settings, stop_);
  });
  if (stop_) return std::nullopt;
  if (!outcome.isDone) {
    entry.failure = outcome.failure;
    entry.isFault = outcome.isFault;
    say_(fmt::format("FAILED   {}: {}", name, entry.failure));
    return entry;
  }
  Json json = readJsonFile((folder / "entry.json").string());
  json["peak memory"] = outcome.peakMemory;
  writeTextFile((folder / "entry.json").string(), jsonText(json));
  readEntry(folder, key, entry);
  say_(fmt::format("rendered {}: {:.3g} s, {} images", name, entry.points.back().seconds,
                   entry.points.size()));
  return entry;
}

BenchRunner::Reference BenchRunner::reference(const BenchScene& scene) {
  const BenchReference& wanted = scene.reference;
  if (!wanted.file.empty()) return {wanted.file, "", false};
  RenderSettings settings = settingsFor(scene);
  settings.seed = wanted.seed;
  settings.integrators = wanted.integrators;
  settings.passes = wanted.passes;
  settings.maxSeconds = wanted.seconds;
  const std::string key =
      fmt::format("{} | {} | {} {} | {}", sceneKey(scene), fmt::join(wanted.integrators, " "),
                  wanted.passes.value_or(0), wanted.seconds.value_or(0), wanted.seed);
  const fs::path folder = fs::path(folder_) / "references";
  const std::string file =
      (folder / fmt::format("{}-{:016x}.exr", fileName(scene.name), hashText(key))).string();
  if (fs::exists(file)) {
    say_(fmt::format("kept     the reference of {}", scene.name));
    return {file, "", false};
  }
  makeFolder(folder);
  const ChildOutcome outcome = runInChild([&] {
    Log log({Verbosity::Quiet, false, false});
    const RenderResult result = renderFrame(scene.file, settings, log, stop_);
    refuseInterrupted(result);
    writeImage(file, result.image);
  });
  if (stop_ && !fs::exists(file)) return {};
  if (!outcome.isDone) {
    say_(fmt::format("FAILED   the reference of {}: {}", scene.name, outcome.failure));
    return {"", outcome.failure, outcome.isFault};
  }
  say_(fmt::format("rendered the reference of {}: {:.3g} s of processor time", scene.name,
                   outcome.cpuSeconds));
  return {file, "", false};
}

}  // namespace brume
