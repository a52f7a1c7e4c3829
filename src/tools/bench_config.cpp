// SPDX-License-Identifier: Apache-2.0
#include "tools/bench_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <thread>

#include "core/error.h"
#include "tools/json_object.h"

namespace brume {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMaxCount = 1 << 24;
/// A reference uses other random numbers than every render that it judges.
constexpr std::uint64_t kReferenceSeed = 0x5ef0000;

std::optional<int> count(JsonObject& object, const char* key) {
  const auto n = object.whole(key, 1, kMaxCount);
  return n ? std::optional(static_cast<int>(*n)) : std::nullopt;
}

std::optional<double> duration(JsonObject& object, const char* key) {
  return object.number(key, 1e-3, 1e9);
}

class ConfigReader {
 public:
  explicit ConfigReader(const std::string& path)
      : path_(path), folder_(fs::path(path).parent_path()), json_(readJsonFile(path)) {}

  BenchConfig read();

 private:
  std::string resolve(const std::string& file) const { return (folder_ / file).string(); }
  BenchScene readScene(JsonObject& object) const;
  BenchReference readReference(JsonObject& object) const;
  static BenchMethod readMethod(JsonObject& object);
  void check(const BenchConfig& config) const;

  std::string path_;
  fs::path folder_;
  Json json_;
};

BenchReference ConfigReader::readReference(JsonObject& object) const {
  BenchReference reference;
  reference.file = object.string("file").value_or("");
  if (!reference.file.empty()) {
    reference.file = resolve(reference.file);
    object.finish();
    return reference;
  }
  reference.integrators = object.strings("integrator");
  if (reference.integrators.empty()) reference.integrators = {"volpath"};
  reference.passes = count(object, "passes");
  reference.seconds = duration(object, "seconds");
  reference.seed =
      static_cast<std::uint64_t>(object.whole("seed", 0, INT64_MAX).value_or(kReferenceSeed));
  if (!reference.passes && !reference.seconds)
    throw SceneError(
        fmt::format("{}: a reference needs \"file\", \"passes\" or \"seconds\"", object.where()));
  object.finish();
  return reference;
}

BenchScene ConfigReader::readScene(JsonObject& object) const {
  BenchScene scene;
  const auto file = object.string("file");
  if (!file) object.fail("file", "given: the scene file");
  scene.file = resolve(*file);
  scene.name = object.string("name").value_or(fs::path(*file).stem().string());
  if (const auto size = object.wholes("resolution", 1, 1 << 20); !size.empty()) {
    if (size.size() != 2) object.fail("resolution", "a list of width and height");
    scene.resolution = {static_cast<int>(size[0]), static_cast<int>(size[1])};
  }
  scene.samplesPerPixel = count(object, "spp");
  scene.methods = object.strings("methods");
  auto reference = object.object("reference");
  if (!reference) object.fail("reference", "given: {\"file\": ...} or {\"passes\": ...}");
  scene.reference = readReference(*reference);
  object.finish();
  return scene;
}

BenchMethod ConfigReader::readMethod(JsonObject& object) {
  BenchMethod method;
  method.integrators = object.strings("integrator");
  const auto name = object.string("name");
  if (!name && method.integrators.empty())
    throw SceneError(fmt::format("{} needs a \"name\" or an \"integrator\"", object.where()));
  method.name = name ? *name : method.integrators.front();
  method.passes = count(object, "passes");
  method.seconds = duration(object, "seconds");
  object.finish();
  return method;
}

void ConfigReader::check(const BenchConfig& config) const {
  const auto fail = [&](const std::string& text) {
    throw SceneError(fmt::format("{}: {}", path_, text));
  };
  if (config.scenes.empty()) fail("\"scenes\" lists none");
  if (config.methods.empty()) fail("\"methods\" lists none");
  std::vector<std::string> names;
  const auto isMethod = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const BenchMethod& method : config.methods) {
    if (isMethod(method.name)) fail(fmt::format("two methods are named \"{}\"", method.name));
    names.push_back(method.name);
    if (!config.passes && !config.seconds && !method.passes && !method.seconds)
      fail(fmt::format("nothing ends method \"{}\": give \"seconds\" or \"passes\"", method.name));
  }
  const auto checkName = [&](const std::string& name) {
    if (!isMethod(name))
      fail(fmt::format("there is no method \"{}\"{}", name, nearestSpelling(name, names)));
  };
  if (!config.baseline.empty()) checkName(config.baseline);
  for (std::size_t i = 0; i < config.scenes.size(); ++i) {
    for (const std::string& name : config.scenes[i].methods) checkName(name);
    for (std::size_t j = 0; j < i; ++j)
      if (config.scenes[i].name == config.scenes[j].name)
        fail(fmt::format("two scenes are named \"{}\"", config.scenes[i].name));
  }
}

BenchConfig ConfigReader::read() {
  JsonObject root(json_, path_);
  BenchConfig config;
  config.file = path_;
  config.title = root.string("title").value_or(fs::path(path_).stem().string());
  for (JsonObject& object : root.objects("scenes")) config.scenes.push_back(readScene(object));
  for (JsonObject& object : root.objects("methods")) config.methods.push_back(readMethod(object));
  config.baseline = root.string("baseline").value_or("");
  config.passes = count(root, "passes");
  config.seconds = duration(root, "seconds");
  for (const std::int64_t n : root.wholes("threads", 1, 4096))
    config.threads.push_back(static_cast<int>(n));
  if (config.threads.empty())
    config.threads = {static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))};
  for (const std::int64_t n : root.wholes("seeds", 0, INT64_MAX))
    config.seeds.push_back(static_cast<std::uint64_t>(n));
  if (config.seeds.empty()) config.seeds = {0};
  if (const auto csv = root.string("foreign")) config.foreign = resolve(*csv);
  root.finish();
  check(config);
  if (config.baseline.empty()) config.baseline = config.methods.front().name;
  return config;
}

}  // namespace

bool BenchConfig::runs(const BenchScene& scene, const BenchMethod& method) const {
  return scene.methods.empty() ||
         std::find(scene.methods.begin(), scene.methods.end(), method.name) != scene.methods.end();
}

BenchConfig readBenchConfig(const std::string& path) { return ConfigReader(path).read(); }

}  // namespace brume
