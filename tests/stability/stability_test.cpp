// SPDX-License-Identifier: Apache-2.0
// Runs the cases of stability_case.h. With BRUME_STABILITY_TABLE=FILE in the environment, what was
// measured is written to FILE as docs/stability.md (scripts/stability_table does that).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "stability/stability_case.h"
#include "support/folders.h"

namespace brume::test {
namespace {

struct StabilityParam {
  StabilityCase stability;
  Form form;
};
void PrintTo(const StabilityParam& p, std::ostream* out) { *out << p.stability.name; }
std::string nameOf(const testing::TestParamInfo<StabilityParam>& info) {
  return asTestName(info.param.stability.group + "_" + info.param.stability.name);
}

std::vector<StabilityParam> allIn(Form form) {
  std::vector<StabilityParam> params;
  for (const StabilityCase& c : allStabilityCases()) params.push_back({c, form});
  return params;
}

std::string rowStart(const StabilityCase& c) { return fmt::format("| {} | {} |", c.group, c.name); }

/// Rows by the position of their case, written when all tests are done.
std::map<std::size_t, std::string>& measuredRows() {
  static std::map<std::size_t, std::string> rows;
  return rows;
}

void keepRow(const StabilityCase& c, const StabilityResult& r) {
  const auto all = allStabilityCases();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (rowStart(all[i]) == rowStart(c))
      measuredRows()[i] = fmt::format("{} {:.1e} | {:.1e} | {:.0e} | {} | {} |\n", rowStart(c),
                                      r.difference, r.noise, c.tolerance, r.faults, c.reason);
}

class WriteTable : public testing::Environment {
 public:
  void TearDown() override {
    const char* file = std::getenv("BRUME_STABILITY_TABLE");
    if (!file) return;
    std::ofstream out(file);
    out << "# Stability\n\n"
           "Written by `scripts/stability_table`; a test fails when a case has no row. Each case "
           "renders a scene in two forms that must show\nthe same, with the same random numbers, "
           "or "
           "one whose value is known. *Difference*: largest relative difference of a channel's "
           "mean.\n"
           "*Noise*: its standard error; where the same paths are followed it is far below that of "
           "either image. *Allowed*: beyond four times the\nnoise. *Faults*: radiances that were "
           "NaN, infinite or negative. Integrator: volpath.\n\n"
           "| group | case | difference | noise | allowed | faults | the allowed is for |\n"
           "| --- | --- | --- | --- | --- | --- | --- |\n";
    for (const auto& [position, row] : measuredRows()) out << row;
  }
};
[[maybe_unused]] const auto* const kTable =
    testing::AddGlobalTestEnvironment(new WriteTable);  // NOLINT: googletest owns it

class Stability : public testing::TestWithParam<StabilityParam> {};

TEST_P(Stability, Holds) {
  const auto& [c, form] = GetParam();
  const StabilityResult r = c.run(form);
  keepRow(c, r);
  EXPECT_EQ(r.faults, 0u);
  EXPECT_LE(r.noise, c.maxNoise) << "says nothing";
  // Four standard errors: fails by chance once in 16,000.
  EXPECT_LE(r.difference, std::max(c.tolerance, 4 * r.noise)) << "noise " << r.noise;
}

INSTANTIATE_TEST_SUITE_P(Quick, Stability, testing::ValuesIn(allIn(Form::Quick)), nameOf);
INSTANTIATE_TEST_SUITE_P(Full, Stability, testing::ValuesIn(allIn(Form::Full)), nameOf);

TEST(StabilityTable, HasARowForEachCaseAndNoOther) {
  std::ifstream in(test::sourceFolder() / "docs/stability.md");
  ASSERT_TRUE(in) << "run scripts/stability_table";
  std::set<std::string> rows;
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("| ") && !line.starts_with("| group") && !line.starts_with("| ---")) {
      const std::size_t second = line.find(" |", line.find(" |") + 2);
      rows.insert(line.substr(0, second + 2));
    }
  std::set<std::string> cases;
  for (const StabilityCase& c : allStabilityCases()) cases.insert(rowStart(c));
  EXPECT_EQ(rows, cases) << "run scripts/stability_table";
}

}  // namespace
}  // namespace brume::test
