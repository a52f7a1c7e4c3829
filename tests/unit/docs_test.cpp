// SPDX-License-Identifier: Apache-2.0
// Links of the pages to files of this checkout lead somewhere.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "support/folders.h"

namespace {

namespace fs = std::filesystem;

TEST(Docs, LinksLeadToFiles) {
  const fs::path root = brume::test::sourceFolder();
  std::vector<fs::path> pages{root / "README.md"};
  for (const auto& entry : fs::directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  const std::regex link(R"(\]\(([^)#:]+)\))");  // a colon marks an address elsewhere
  int links = 0;
  for (const fs::path& page : pages) {
    std::ostringstream stream;
    stream << std::ifstream(page).rdbuf();
    const std::string text = stream.str();
    for (std::sregex_iterator i(text.begin(), text.end(), link), end; i != end; ++i, ++links)
      EXPECT_TRUE(fs::exists(page.parent_path() / (*i)[1].str()))
          << page.filename() << " links to " << (*i)[1];
  }
  EXPECT_GT(links, 5);
}

}  // namespace
