// SPDX-License-Identifier: Apache-2.0
// The registry against the source files: nothing is dropped by the linker, and the word in the
// scene file is the name of the source file.
#include "core/registry.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "support/folders.h"
#include "tools/plugin_manual.h"

namespace brume {
namespace {

namespace fs = std::filesystem;

/// A registration line as the source has it.
struct Registration {
  fs::path file;
  std::string name;
};

std::string readFile(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<Registration> registrationsInSources() {
  const fs::path src = test::sourceFolder() / "src";
  const std::regex pattern(R"re(RegisterPlugin<[^;{]*>\s*\w+\s*\{\s*"([^"]+)")re");
  std::vector<Registration> registrations;
  for (const auto& entry : fs::recursive_directory_iterator(src)) {
    if (entry.path().extension() != ".cpp") continue;
    const std::string text = readFile(entry.path());
    for (std::sregex_iterator i(text.begin(), text.end(), pattern), end; i != end; ++i)
      registrations.push_back({fs::relative(entry.path(), src), (*i)[1]});
  }
  return registrations;
}

/// Second names that PBRT-v2 has for a plugin: they live in its file.
const std::map<std::string, std::string>& fileOfAlias() {
  static const std::map<std::string, std::string> files{
      {"area", "diffuse"}, {"exinfinite", "infinite"}, {"exphotonmap", "photonmap"}};
  return files;
}

TEST(Registry, HoldsEveryRegistrationOfTheSources) {
  std::multiset<std::string> inSources, inRegistry;
  for (const Registration& r : registrationsInSources()) inSources.insert(r.name);
  for (const PluginInfo* info : allPlugins()) inRegistry.insert(std::string(info->name));
  EXPECT_FALSE(inSources.empty());
  EXPECT_EQ(inSources, inRegistry);
}

TEST(Registry, NameInTheSceneIsNameOfTheFile) {
  for (const Registration& r : registrationsInSources()) {
    const auto alias = fileOfAlias().find(r.name);
    const std::string file = alias == fileOfAlias().end() ? r.name : alias->second;
    EXPECT_EQ(r.file.stem().string(), file) << "registered in src/" << r.file.string();
  }
}

TEST(Registry, NoPluginLivesInCore) {
  for (const Registration& r : registrationsInSources())
    EXPECT_NE(r.file.begin()->string(), "core") << r.file.string();
}

TEST(Registry, EveryNameIsThereOnceInItsKind) {
  std::set<std::pair<std::string_view, std::string_view>> seen;
  for (const PluginInfo* info : allPlugins())
    EXPECT_TRUE(seen.emplace(info->kind, info->name).second) << info->kind << ' ' << info->name;
}

TEST(Registry, EveryPluginIsDescribed) {
  for (const PluginInfo* info : allPlugins()) {
    EXPECT_FALSE(info->summary.empty()) << info->kind << ' ' << info->name;
    std::set<std::string> names;
    for (const ParamRecord& record : info->describe()) {
      EXPECT_FALSE(record.text.empty()) << info->name << ": " << record.name;
      EXPECT_TRUE(names.insert(record.type + " " + record.name).second)
          << info->name << " declares \"" << record.name << "\" twice";
    }
  }
}

TEST(PluginManual, PageInDocsIsFresh) {
  const std::string page = readFile(test::sourceFolder() / "docs" / "plugins.md");
  EXPECT_TRUE(page == pluginManual({"", true}))
      << "docs/plugins.md is stale: run build/brume plugins --markdown > docs/plugins.md";
}

TEST(PluginManual, ListsEveryPluginInOneLine) {
  const std::string list = pluginManual({});
  for (const PluginInfo* info : allPlugins())
    EXPECT_NE(list.find("\n  " + std::string(info->name) + " "), std::string::npos) << info->name;
}

TEST(PluginManual, ShowsTheParametersOfOnePlugin) {
  const std::string text = pluginManual({"sphere", false});
  EXPECT_NE(text.find("Shape \"sphere\""), std::string::npos) << text;
  EXPECT_NE(text.find("float radius"), std::string::npos) << text;
}

TEST(PluginManual, UnknownNameGetsTheNearestSpelling) {
  try {
    pluginManual({"sphrere", false});
    FAIL() << "no error";
  } catch (const SceneError& error) {
    EXPECT_STREQ(error.what(),
                 "no plugin or kind of plugin is called 'sphrere' (did you mean 'sphere'?); brume "
                 "plugins lists them");
  }
}

}  // namespace
}  // namespace brume
