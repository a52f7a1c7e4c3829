// SPDX-License-Identifier: Apache-2.0
// `brume regress`: references, verdicts, what is left of a failure.
#include <gtest/gtest.h>

#include "core/io/image.h"
#include "support/run_program.h"

namespace brume::test {
namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A lit ball; `kd` is what a change of the program would alter.
std::string scene(const std::string& kd) {
  return R"(Film "image" "integer xresolution" 16 "integer yresolution" 16
Sampler "random" "integer pixelsamples" 32
LookAt 0 0 -5  0 0 0  0 1 0
Camera "perspective" "float fov" 30
WorldBegin
LightSource "infinite"
Material "matte" "color Kd" [)" +
         kd + R"(]
Shape "sphere"
WorldEnd
)";
}

class Regress : public ::testing::Test {
 protected:
  ProgramResult run(std::vector<std::string> arguments = {}) const {
    arguments.insert(arguments.begin(), {"regress", "scenes"});
    return runBrume({arguments, folder_.path()});
  }
  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories(folder_.path() / "scenes");
    folder_.write("scenes/" + name, text);
  }
  TemporaryFolder folder_;
};

TEST_F(Regress, PassesAfterUpdateAndFailsAfterAChange) {
  write("ball.pbrt", scene(".5 .5 .5"));
  write("other.pbrt", scene(".2 .2 .6"));
  ASSERT_EQ(run({"--update"}).exitCode, 0);
  const ProgramResult good = run();
  EXPECT_EQ(good.exitCode, 0) << good.out << good.err;
  EXPECT_TRUE(contains(good.out, "passed  ball")) << good.out;
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "regress-failures"));

  // 6 % brighter: a tenth of one pixel's noise, and far outside that of the whole.
  write("ball.pbrt", scene(".53 .53 .53"));
  const ProgramResult bad = run();
  EXPECT_EQ(bad.exitCode, 1);
  EXPECT_TRUE(contains(bad.out, "FAILED  ball")) << bad.out;
  EXPECT_TRUE(contains(bad.out, "passed  other")) << bad.out;
  for (const char* name : {"ball.exr", "ball.png", "ball.reference.png", "ball.difference.png",
                           "ball.p.png", "ball.blocks.png", "index.html"})
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "regress-failures" / name)) << name;
  const std::string page = readFile(folder_.path() / "regress-failures" / "index.html");
  EXPECT_TRUE(contains(page, "<h1>1 of 2 scenes failed</h1>")) << page.substr(0, 2000);
  EXPECT_TRUE(contains(page, "data:image/png;base64,"));
  EXPECT_FALSE(contains(page, "other"));
  EXPECT_EQ(run({"other"}).exitCode, 0) << "only the scenes that are named count";
}

TEST_F(Regress, ReferencesMayComeFromAnotherIntegrator) {
  write("ball.pbrt", scene(".5 .5 .5"));
  write("regress.json", R"({"scenes": {"ball": {"reference integrator": "volpath:maxdepth=1",
    "reference passes": 8}}})");
  ASSERT_EQ(run({"--update"}).exitCode, 0);
  const LayeredImage reference =
      readLayeredImage((folder_.path() / "scenes" / "ball.ref.exr").string());
  EXPECT_TRUE(contains(reference.metadata.at("brume:GlobalIntegrator"), "volpath"));
  EXPECT_EQ(reference.channels.at("samples")[0], 8 * 32);
  EXPECT_EQ(run().exitCode, 0);
}

TEST_F(Regress, LimitsReplaceTheZTest) {
  write("ball.pbrt", scene(".5 .5 .5"));
  write("regress.json", R"({"z-test": false, "max relmse": 1})");
  ASSERT_EQ(run({"--update"}).exitCode, 0);
  write("ball.pbrt", scene(".53 .53 .53"));
  EXPECT_EQ(run().exitCode, 0);
  write("regress.json", R"({"z-test": false, "max relmse": 1e-5})");
  const ProgramResult bad = run();
  EXPECT_EQ(bad.exitCode, 1);
  EXPECT_TRUE(contains(bad.out, "relMSE")) << bad.out;
}

TEST_F(Regress, FailuresOfOneSceneDoNotEndTheOthers) {
  write("a.pbrt", "Film \"imoge\"\nWorldBegin\nWorldEnd\n");
  write("b.pbrt", scene(".5 .5 .5"));
  write("c.pbrt", scene(".5 .5 .5"));
  ASSERT_EQ(run({"--update", "b"}).exitCode, 0);
  std::filesystem::copy_file(folder_.path() / "scenes" / "b.ref.exr",
                             folder_.path() / "scenes" / "a.ref.exr");
  const ProgramResult result = run();
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_TRUE(contains(result.out, "passed  b")) << result.out;
  EXPECT_TRUE(contains(result.out, "\n        scenes/a.pbrt:1:6: error: unknown Film \"imoge\""))
      << result.out;
  EXPECT_TRUE(contains(result.out, "\n          Film \"imoge\"\n               ^\n")) << result.out;
  EXPECT_TRUE(contains(result.out, "there is no reference")) << result.out;
}

TEST_F(Regress, UsersFaultsAreNamed) {
  EXPECT_TRUE(contains(run().err, "cannot read the folder 'scenes'"));
  write("note.txt", "");
  EXPECT_TRUE(contains(run().err, "there is no scene (*.pbrt) in 'scenes'"));
  write("ball.pbrt", scene(".5 .5 .5"));
  EXPECT_TRUE(contains(run({"bell"}).err, "there is no scene 'bell' (did you mean 'ball'?)"));
  write("regress.json", R"({"scenes": {"bell": {}}})");
  EXPECT_TRUE(contains(run().err, "there is no scene 'bell' (did you mean 'ball'?)"));
  write("regress.json", R"({"pases": 3})");
  const ProgramResult result = run();
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_TRUE(contains(result.err, "unknown key \"pases\" (did you mean 'passes'?)")) << result.err;
  write("regress.json", R"({"z-test": false})");
  EXPECT_TRUE(contains(run().err, "without a z-test there must be a limit"));
}

}  // namespace
}  // namespace brume::test
