// SPDX-License-Identifier: Apache-2.0
// The command line without a render: help, spelling, values, texts of errors.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>

#include "support/folders.h"
#include "support/run_program.h"

namespace brume::test {
namespace {

using ::testing::TestWithParam;
using ::testing::Values;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Options, HelpNamesOptionsCommandsAndExitCodes) {
  const ProgramResult result = runBrume({{"--help"}});
  EXPECT_EQ(result.exitCode, 0) << result.err;
  for (const char* word :
       {"--outfile",    "--threads", "--quick", "--quiet",   "--verbose",    "--crop",
        "--resolution", "--spp",     "--seed",  "--stats",   "--integrator", "--passes",
        "--time",       "--error",   "--check", "--plan",    "--strict",     "--variance",
        "--layers",     "diff",      "plugins", "Exit codes"})
    EXPECT_TRUE(contains(result.out, word)) << word;
  EXPECT_EQ(result.err, "");
}

TEST(Options, HelpOfACommandIsItsOwn) {
  const ProgramResult result = runBrume({{"diff", "--help"}});
  EXPECT_EQ(result.exitCode, 0);
  EXPECT_TRUE(contains(result.out, "--max-relmse"));
  EXPECT_FALSE(contains(result.out, "--integrator"));
}

TEST(Options, VersionIsOneLine) {
  const ProgramResult result = runBrume({{"--version"}});
  EXPECT_EQ(result.exitCode, 0);
  EXPECT_TRUE(result.out.starts_with("brume ")) << result.out;
}

/// A call that the command line refuses, and what it says.
struct Refused {
  std::vector<std::string> arguments;
  std::string message;
};
std::ostream& operator<<(std::ostream& out, const Refused& refused) {
  for (const std::string& word : refused.arguments) out << word << ' ';
  return out;
}

class RefusedOptions : public TestWithParam<Refused> {};

TEST_P(RefusedOptions, SayWhy) {
  const ProgramResult result = runBrume({GetParam().arguments});
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_EQ(result.err, "brume: error: " + GetParam().message + "\n");
  EXPECT_EQ(result.out, "");
}

INSTANTIATE_TEST_SUITE_P(
    All, RefusedOptions,
    Values(
        Refused{{}, "no scene file given; see brume --help"},
        Refused{{"--spq", "4", "a.pbrt"},
                "unknown option '--spq' (did you mean '--spp'?); see brume --help"},
        Refused{{"a.pbrt", "--threds=2"},
                "unknown option '--threds' (did you mean '--threads'?); see brume --help"},
        Refused{{"diff", "a.exr", "b.exr", "--max-rel-mse", "1"},
                "unknown option '--max-rel-mse' (did you mean '--max-relmse'?); see brume --help"},
        Refused{{"merge"},
                "'merge' is neither a scene file nor a command of this brume; the commands are "
                "'diff', 'plugins', 'photons', 'regress' or 'bench'"},
        Refused{{"plugin"},
                "'plugin' is neither a scene file nor a command of this brume (did you mean "
                "'plugins'?); the commands are 'diff', 'plugins', 'photons', 'regress' or 'bench'"},
        Refused{{"a.pbrt", "--spp", "0"},
                "--spp cannot be '0': it wants a whole number from 1 to 1073741824"},
        Refused{{"a.pbrt", "--spp", "4.5"},
                "--spp cannot be '4.5': it wants a whole number from 1 to 1073741824"},
        Refused{{"a.pbrt", "--threads", "many"},
                "--threads cannot be 'many': it wants a whole number from 1 to 4096"},
        Refused{{"a.pbrt", "--seed=-1"},
                "--seed cannot be '-1': it wants a whole number from 0 to 2^64 - 1"},
        Refused{{"a.pbrt", "--time", "5d"},
                "--time cannot be '5d': it wants a time such as 60s, 2m or 1.5h (seconds when no "
                "unit is given)"},
        Refused{{"a.pbrt", "--error", "0"}, "--error cannot be '0': it wants a number above 0"},
        Refused{{"a.pbrt", "--error", "nan"}, "--error cannot be 'nan': it wants a number above 0"},
        Refused{{"a.pbrt", "--resolution", "640"},
                "--resolution cannot be '640': it wants width and height in pixels, such as "
                "640x480"},
        Refused{{"a.pbrt", "--resolution", "640x-2"},
                "--resolution cannot be '640x-2': it wants width and height in pixels, such as "
                "640x480"},
        Refused{
            {"a.pbrt", "--crop", "0,1,0"},
            "--crop cannot be '0,1,0': it wants x0,x1,y0,y1: fractions of the image from 0 to 1 "
            "with x0 < x1 and y0 < y1"},
        Refused{{"a.pbrt", "--crop", "0.5,0.5,0,1"},
                "--crop cannot be '0.5,0.5,0,1': it wants x0,x1,y0,y1: fractions of the image from "
                "0 to 1 with x0 < x1 and y0 < y1"},
        Refused{{"a.pbrt", "--quiet", "--verbose"}, "--quiet and --verbose exclude each other"},
        Refused{{"a.pbrt", "--check", "--plan"}, "--check and --plan exclude each other"},
        Refused{{"--spp", "4", "plugins"}, "--spp does not go with the command 'plugins'"},
        Refused{{"diff", "a.exr", "b.exr", "--z-test", "2"},
                "--z-test wants a significance level below 1, such as 0.01"},
        Refused{{"diff", "a.exr", "b.exr", "c.exr"},
                "'c.exr' is one word too many; see brume diff --help"}));

TEST(Options, MissingValueIsAnError) {
  const ProgramResult result = runBrume({{"a.pbrt", "--spp"}});
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_TRUE(contains(result.err, "--spp")) << result.err;
}

TEST(Options, EmptyValueIsAnError) {
  const ProgramResult result = runBrume({{"a.pbrt", "--outfile", ""}});
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_TRUE(contains(result.err, "--outfile")) << result.err;
}

TEST(Options, MissingSceneIsNamedWithTheReason) {
  const ProgramResult result = runBrume({{"no/such.pbrt"}});
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_TRUE(contains(result.err, "error")) << result.err;
  EXPECT_TRUE(contains(result.err, "no/such.pbrt")) << result.err;
  EXPECT_TRUE(contains(result.err, "No such file")) << result.err;
}

TEST(Options, PluginsOfAKindAreListed) {
  const ProgramResult result = runBrume({{"plugins", "PixelFilter"}});
  EXPECT_EQ(result.exitCode, 0) << result.err;
  EXPECT_TRUE(contains(result.out, "PixelFilter \"gaussian\"")) << result.out;
  EXPECT_TRUE(contains(result.out, "float alpha")) << result.out;
}

TEST(Options, AFullStandardOutputIsAnError) {
  // /dev/full accepts nothing: the manual must not vanish silently.
  const std::string command =
      "'" + test::binaryFolder().string() + "/brume' plugins >/dev/full 2>/dev/null";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 1);
}

}  // namespace
}  // namespace brume::test
