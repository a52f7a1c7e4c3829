// SPDX-License-Identifier: Apache-2.0
// The layers of DESIGN.md 3, read off the includes: who may include whom, and that each third-party
// library stays in one pair of files.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "support/folders.h"

namespace {

namespace fs = std::filesystem;

/// One #include: of `header`, in the file `file` (relative to src/).
struct Include {
  fs::path file;
  std::string header;
  bool isSystem = false;  ///< <...>
};

std::vector<Include> allIncludes() {
  const fs::path src = brume::test::sourceFolder() / "src";
  const std::regex pattern(R"re(^\s*#\s*include\s*([<"])([^>"]+)[>"])re");
  std::vector<Include> includes;
  for (const auto& entry : fs::recursive_directory_iterator(src)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".h" && extension != ".cpp") continue;
    std::ifstream in(entry.path());
    for (std::string line; std::getline(in, line);) {
      std::smatch match;
      if (std::regex_search(line, match, pattern))
        includes.push_back({fs::relative(entry.path(), src), match[2], match[1] == "<"});
    }
  }
  return includes;
}

std::string topFolder(const fs::path& path) { return path.begin()->string(); }

/// The folders that a folder may include from, beside itself.
const std::map<std::string, std::set<std::string>>& allowedFolders() {
  static const std::set<std::string> core{"core"};
  static const std::map<std::string, std::set<std::string>> allowed{
      {"core", {}},
      {"shapes", core},
      {"lights", core},
      {"cameras", core},
      {"samplers", core},
      {"filters", core},
      {"film", core},
      {"materials", core},
      {"textures", core},
      {"volumes", core},
      {"accelerators", core},
      {"transport", {"core", "accelerators"}},
      {"integrators", {"core", "accelerators", "transport"}},
      {"renderers", {"core", "accelerators", "transport", "integrators"}},
      {"tools", {"core", "accelerators", "transport", "integrators", "renderers"}},
      {"main", {"core", "renderers", "tools"}},
  };
  return allowed;
}

TEST(Layers, IncludesFollowTheLayers) {
  const std::vector<Include> includes = allIncludes();
  ASSERT_GT(includes.size(), 100u);
  for (const Include& include : includes) {
    if (include.isSystem) continue;
    const std::string from = topFolder(include.file), to = topFolder(include.header);
    const auto allowed = allowedFolders().find(from);
    ASSERT_NE(allowed, allowedFolders().end()) << "unknown folder src/" << from;
    EXPECT_TRUE(from == to || allowed->second.count(to) == 1)
        << "src/" << include.file.string() << " includes " << include.header;
  }
}

TEST(Layers, QuotedIncludesAreOurs) {
  for (const Include& include : allIncludes()) {
    if (include.isSystem) continue;
    EXPECT_TRUE(fs::exists(brume::test::sourceFolder() / "src" / include.header))
        << "src/" << include.file.string() << " includes \"" << include.header << '"';
  }
}

/// Each library (by the start of its headers' names) is known to one .h/.cpp pair; fmt is free.
TEST(Layers, EachLibraryIsInOnePairOfFiles) {
  const std::vector<std::string> libraries{"embree",
                                           "tbb/",
                                           "oneapi/",
                                           "OpenEXR/",
                                           "Imf",
                                           "glm/",
                                           "CLI/",
                                           "nlohmann/",
                                           "stb_image.h",
                                           "stb_image_write.h",
                                           "stb/stb_image.h",
                                           "stb/stb_image_write.h"};
  for (const std::string& library : libraries) {
    std::set<std::string> users;
    for (const Include& include : allIncludes())
      if (include.isSystem && include.header.starts_with(library))
        users.insert(fs::path(include.file).replace_extension().string());
    EXPECT_LE(users.size(), 1u) << library << " is included by " << ::testing::PrintToString(users);
  }
}

TEST(Layers, OnlyTheCommandLineAndTheLogPrint) {
  // Libraries throw and log; standard output belongs to main.
  const std::regex printing(R"(std::cout|std::cerr|\bprintf\s*\(|\bexit\s*\(|\babort\s*\()");
  const fs::path src = brume::test::sourceFolder() / "src";
  for (const auto& entry : fs::recursive_directory_iterator(src)) {
    const fs::path file = fs::relative(entry.path(), src);
    if (entry.path().extension() != ".cpp" || topFolder(file) == "main") continue;
    std::ifstream in(entry.path());
    int number = 0;
    for (std::string line; std::getline(in, line);) {
      ++number;
      const std::string code = line.substr(0, line.find("//"));
      EXPECT_FALSE(std::regex_search(code, printing))
          << "src/" << file.string() << ':' << number << ": " << line;
    }
  }
}

}  // namespace
