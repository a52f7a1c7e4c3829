// SPDX-License-Identifier: Apache-2.0
// The table of scripts/mutate fits the code: each old text occurs once in its file.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "support/folders.h"

namespace brume {
namespace {

struct Mutation {
  std::string name, file, before, after, test;
};

std::vector<Mutation> readMutations() {
  std::vector<Mutation> all;
  std::ifstream in(test::sourceFolder() / "tests/mutations.txt");
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    const std::size_t space = line.find(' ');
    const std::string key = line.substr(0, space), value = line.substr(space + 1);
    if (key == "name") all.push_back({value, "", "", "", ""});
    if (all.empty()) continue;
    Mutation& m = all.back();
    if (key == "file") m.file = value;
    if (key == "old") m.before = value;
    if (key == "new") m.after = value;
    if (key == "test") m.test = value;
  }
  return all;
}

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

TEST(Mutations, FitTheCode) {
  const auto all = readMutations();
  EXPECT_GE(all.size(), 14u);
  for (const Mutation& m : all) {
    std::ifstream in(test::sourceFolder() / m.file);
    ASSERT_TRUE(in) << m.name << ": " << m.file;
    std::stringstream text;
    text << in.rdbuf();
    EXPECT_EQ(occurrences(text.str(), m.before), 1u) << m.name << ": " << m.before;
    EXPECT_FALSE(m.before.empty()) << m.name;
    EXPECT_NE(m.before, m.after) << m.name;
    const std::string program = m.test.substr(0, m.test.find(' '));
    EXPECT_TRUE(program == "unit" || program == "accuracy" || program == "stability") << m.name;
    EXPECT_GT(m.test.size(), program.size() + 1) << m.name << ": no filter";
  }
}

}  // namespace
}  // namespace brume
