// SPDX-License-Identifier: Apache-2.0
#include "tools/regress_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/error.h"
#include "core/math.h"
#include "tools/json_object.h"

namespace brume {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRulesFile = "regress.json";
constexpr std::int64_t kMaxPasses = 1 << 24;

/// Reads the rules that an object gives; the others keep their values.
void readRules(JsonObject& object, RegressRules& rules) {
  const auto words = [&](const char* key, std::vector<std::string>& value) {
    if (object.has(key)) value = object.strings(key);
    object.any(key);
  };
  const auto limit = [&](const char* key, std::optional<double>& value) {
    if (const auto x = object.number(key, 0, kInfinity)) value = x;
  };
  words("integrator", rules.integrators);
  words("reference integrator", rules.referenceIntegrators);
  const auto passes = [&](const char* key, int& value) {
    if (const auto n = object.whole(key, 1, kMaxPasses)) value = static_cast<int>(*n);
  };
  passes("passes", rules.passes);
  passes("reference passes", rules.referencePasses);
  if (const Json* z = object.any("z-test"); z && z->is_boolean() && !z->get<bool>())
    rules.zTest.reset();
  else if (z)
    rules.zTest = object.number("z-test", 1e-300, 1);
  if (const auto n = object.whole("block", 1, 1 << 20)) rules.block = static_cast<int>(*n);
  limit("max relmse", rules.maxRelMse);
  limit("max flip", rules.maxFlip);
  limit("max mean ratio error", rules.maxMeanRatioError);
  if (!rules.zTest && !rules.maxRelMse && !rules.maxFlip && !rules.maxMeanRatioError)
    throw SceneError(fmt::format(
        "{}: without a z-test there must be a limit: \"max relmse\", \"max flip\" or \"max mean "
        "ratio error\"",
        object.where()));
}

std::vector<std::string> sceneNames(const fs::path& folder) {
  std::error_code error;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".pbrt") names.push_back(entry.path().stem().string());
  if (error)
    throw SceneError(
        fmt::format("cannot read the folder '{}': {}", folder.string(), error.message()));
  if (names.empty())
    throw SceneError(fmt::format("there is no scene (*.pbrt) in '{}'", folder.string()));
  std::sort(names.begin(), names.end());
  return names;
}

[[noreturn]] void failUnknownScene(const std::string& where, const std::string& name,
                                   const std::vector<std::string>& names) {
  throw SceneError(
      fmt::format("{}: there is no scene '{}'{}", where, name, nearestSpelling(name, names)));
}

}  // namespace

std::vector<RegressScene> findRegressScenes(const RegressOptions& options) {
  const fs::path folder = options.folder;
  const std::vector<std::string> names = sceneNames(folder);
  const auto isScene = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const std::string& name : options.scenes)
    if (!isScene(name)) failUnknownScene(options.folder, name, names);

  // The rules for all, then those of single scenes.
  RegressRules common;
  std::map<std::string, RegressRules> special;
  if (const fs::path file = folder / kRulesFile; fs::exists(file)) {
    const Json json = readJsonFile(file.string());
    JsonObject root(json, file.string());
    readRules(root, common);
    if (auto scenes = root.object("scenes"))
      for (auto& [name, object] : scenes->members()) {
        if (!isScene(name)) failUnknownScene(object.where(), name, names);
        readRules(object, special.emplace(name, common).first->second);
        object.finish();
      }
    root.finish();
  }

  std::vector<RegressScene> scenes;
  for (const std::string& name : options.scenes.empty() ? names : options.scenes) {
    const auto own = special.find(name);
    scenes.push_back({name, (folder / (name + ".pbrt")).string(),
                      (folder / (name + ".ref.exr")).string(),
                      own == special.end() ? common : own->second});
  }
  return scenes;
}

}  // namespace brume
