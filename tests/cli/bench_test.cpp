// SPDX-License-Identifier: Apache-2.0
// `brume bench`: figures, resumption, other renderers' images.
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "support/folders.h"
#include "support/run_program.h"
#include "support/sanitizers.h"

namespace brume::test {
namespace {

using Json = nlohmann::json;

const char* const kScene = R"(Film "image" "integer xresolution" 16 "integer yresolution" 16
Sampler "random" "integer pixelsamples" 8
LookAt 0 0 -5  0 0 0  0 1 0
Camera "perspective" "float fov" 50
WorldBegin
LightSource "infinite"
Volume "homogeneous" "point p0" [-1 -1 -1] "point p1" [1 1 1] "color sigma_s" [.5 .5 .5]
Material "matte"
Shape "sphere" "float radius" .5
WorldEnd
)";

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}
int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

class Bench : public ::testing::Test {
 protected:
  Bench() { folder_.write("ball.pbrt", kScene); }
  static std::string config(const std::string& more) {
    return R"({"scenes": [{"file": "ball.pbrt", "reference": {"integrator": "volpath", "passes": 40}}],
      "methods": [{"name": "volpath", "integrator": "volpath"},
                  {"name": "single", "integrator": ["single", "path"]}], )" +
           more + "}";
  }
  ProgramResult run() const { return runBrume({{"bench", "ball.json"}, folder_.path()}); }
  Json results() const {
    return Json::parse(readFile(folder_.path() / "ball-results" / "results.json"));
  }
  TemporaryFolder folder_;
};

TEST_F(Bench, MeasuresErrorAgainstTimeWithoutRestarts) {
  folder_.write("ball.json", config(R"("passes": 8, "seeds": [1, 2], "threads": 1)"));
  const ProgramResult result = run();
  ASSERT_EQ(result.exitCode, 0) << result.err;
  EXPECT_EQ(count(result.err, "rendered"), 5) << "4 renders and a reference\n" << result.err;

  const Json json = results(), scene = json["scenes"][0];
  EXPECT_EQ(json["baseline"], "volpath");
  EXPECT_FALSE(json["machine"]["processor"].get<std::string>().empty());
  EXPECT_GT(scene["reference noise"], 0);
  ASSERT_EQ(scene["curves"].size(), 4u);
  const Json& points = scene["curves"][0]["points"];
  // 1, 2, 3, 5, 8, 12, 17, 25, 36, 51 samples, and the 64 at the end.
  ASSERT_EQ(points.size(), 11u);
  EXPECT_EQ(points.front()["samples"], 1);
  EXPECT_EQ(points.back()["samples"], 64);
  EXPECT_EQ(points.back()["counters"]["Rays/camera"], 64 * 256);
  for (std::size_t i = 1; i < points.size(); ++i)
    EXPECT_GT(points[i]["seconds"], points[i - 1]["seconds"]);
  // 64 times the samples: the error falls to about a 64th; half of that must be seen. The
  // reference's noise, a fifth of the last error, is subtracted.
  const double first = points.front()["relmse"], last = points.back()["relmse"];
  EXPECT_GT(first / last, 32);
  EXPECT_LT(first / last, 128);
  EXPECT_GT(scene["curves"][0]["peak memory"], 1 << 20);

  const Json& times = scene["times to error"];
  ASSERT_FALSE(times.empty());
  EXPECT_EQ(times[0]["method"], "volpath");
  EXPECT_DOUBLE_EQ(times[0]["times faster"], 1);
  const std::string page = readFile(folder_.path() / "ball-results" / "index.html");
  EXPECT_TRUE(contains(page, "data:image/png;base64,"));
  EXPECT_FALSE(contains(page, "/*DATA*/"));
}

TEST_F(Bench, GoesOnWhereItWas) {
  folder_.write("ball.json", config(R"("passes": 2, "threads": 1)"));
  ASSERT_EQ(run().exitCode, 0);
  const Json before = results();
  const ProgramResult again = run();
  EXPECT_EQ(count(again.err, "kept"), 3) << again.err;
  EXPECT_EQ(count(again.err, "rendered"), 0) << again.err;
  EXPECT_EQ(results()["scenes"], before["scenes"]);
  // Another number of passes is another measurement; the reference stays.
  folder_.write("ball.json", config(R"("passes": 3, "threads": 1)"));
  const ProgramResult more = run();
  EXPECT_EQ(count(more.err, "kept"), 1) << more.err;
  EXPECT_EQ(count(more.err, "rendered"), 2) << more.err;
  // So is another scene of the same name.
  folder_.write("ball.pbrt", std::string(kScene) + "# changed\n");
  EXPECT_EQ(count(run().err, "kept"), 0);
}

TEST_F(Bench, KeepsWhatIsFinishedWhenInterrupted) {
  folder_.write("ball.json", config(R"("seconds": 1, "threads": 1)"));
  ProgramInput input{{"bench", "ball.json"}, folder_.path()};
  input.signal = SIGINT;
  input.waitFor = "rendered the reference";
  const ProgramResult result = runBrume(input);
  EXPECT_EQ(result.exitCode, 130) << result.err;
  EXPECT_TRUE(contains(result.err,
                       "interrupted: what is finished is kept in ball-results; the "
                       "same call goes on there"))
      << result.err;
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "ball-results" / "index.html"));
  const ProgramResult rest = run();
  EXPECT_EQ(rest.exitCode, 0) << rest.err;
  EXPECT_TRUE(contains(rest.err, "kept     the reference of ball")) << rest.err;
}

TEST_F(Bench, ARenderThatIsKilledIsToldAndTriedAgain) {
  folder_.write("ball.json", config(R"("seconds": 1, "threads": 1)"));
  for (const auto& [signal, message] :
       {std::pair{SIGKILL, "ended by signal 9 (Killed), perhaps for want of memory"},
        std::pair{SIGABRT, "ended by signal 6 (Aborted)"},
        std::pair{SIGTERM, "interrupted by a signal to its process"}}) {
    std::filesystem::remove_all(folder_.path() / "ball-results" / "entries");
    ProgramInput input{{"bench", "ball.json"}, folder_.path()};
    input.signal = signal;
    input.signalsChild = true;
    input.waitFor = "the reference of ball";
    const ProgramResult result = runBrume(input);
    EXPECT_EQ(result.exitCode, signal == SIGABRT ? 2 : 1) << result.err;
    EXPECT_TRUE(
        contains(result.err, std::string("FAILED   ball, volpath, 1 threads, seed 0: ") + message))
        << result.err;
    EXPECT_EQ(count(result.err, "rendered ball, single"), 1) << result.err;
    EXPECT_TRUE(contains(result.err, "FAILED   1 of the renders")) << result.err;
    EXPECT_EQ(results()["scenes"][0]["curves"][0]["failure"], message);
  }
  const ProgramResult again = run();
  EXPECT_EQ(again.exitCode, 0) << again.err;
  EXPECT_EQ(count(again.err, "rendered ball, volpath"), 1) << again.err;
  EXPECT_EQ(count(again.err, "kept     ball, single"), 1) << again.err;
}

TEST_F(Bench, AReferenceThatFailsDoesNotEndTheOthers) {
  folder_.write("ball.json", R"({"passes": 2, "threads": 1, "methods": [{"integrator": "volpath"}],
    "scenes": [{"file": "ball.pbrt", "reference": {"integrator": "vilpath", "passes": 2}},
               {"file": "ball.pbrt", "name": "other", "reference": {"passes": 2}}]})");
  const ProgramResult result = run();
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_TRUE(contains(result.err, "FAILED   the reference of ball: ")) << result.err;
  EXPECT_TRUE(contains(results()["scenes"][0]["failure"], "vilpath"));
  EXPECT_EQ(results()["scenes"][1]["curves"][0]["points"].size(), 7u);
  EXPECT_TRUE(contains(readFile(folder_.path() / "ball-results" / "index.html"), "vilpath"));
  // One that is given is looked at before anything is rendered.
  folder_.write("ball.json", R"({"passes": 2, "threads": 1, "methods": [{"integrator": "volpath"}],
    "scenes": [{"file": "ball.pbrt", "reference": {"passes": 2}},
               {"file": "ball.pbrt", "name": "other", "reference": {"file": "none.exr"}}]})");
  const ProgramResult missing = run();
  EXPECT_EQ(missing.exitCode, 1);
  EXPECT_TRUE(contains(missing.err, "none.exr': no such file")) << missing.err;
  EXPECT_EQ(count(missing.err, "rendered"), 0) << missing.err;
}

TEST_F(Bench, WhatIsKeptMustBeWhole) {
  folder_.write("ball.json", config(R"("passes": 2, "threads": 1)"));
  ASSERT_EQ(run().exitCode, 0);
  std::vector<std::filesystem::path> images, entries;
  for (const auto& file :
       std::filesystem::recursive_directory_iterator(folder_.path() / "ball-results" / "entries")) {
    if (file.path().extension() == ".exr") images.push_back(file.path());
    if (file.path().extension() == ".json") entries.push_back(file.path());
  }
  ASSERT_EQ(entries.size(), 2u);
  std::filesystem::remove(images.front());
  EXPECT_EQ(count(run().err, "rendered ball"), 1);
  for (const char* text : {"", "{", "{\"key\": 3}", "[]"}) {
    std::ofstream(entries.front()) << text;
    const ProgramResult result = run();
    EXPECT_EQ(result.exitCode, 0) << result.err;
    EXPECT_EQ(count(result.err, "rendered ball"), 1) << text << result.err;
  }
}

/// Runs a line of sh in which $brume is the program; returns the exit code.
int shell(const TemporaryFolder& folder, const std::string& line) {
  const std::string all = "cd '" + folder.path().string() + "'; brume='" +
                          test::binaryFolder().string() + "/brume'; " + line;
  const int status = std::system(all.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_F(Bench, GoesOnWithoutAReaderOfItsMessages) {
  folder_.write("ball.json", config(R"("passes": 2, "threads": 1)"));
  // The reader ends before the first line comes.
  EXPECT_EQ(shell(folder_,
                  "(sleep .2; \"$brume\" bench ball.json; echo $? > code) 2>&1 | true; "
                  "while [ ! -s code ]; do sleep .1; done; exit $(cat code)"),
            0);
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "ball-results" / "index.html"));
}

TEST_F(Bench, LearnsHowItsProcessesEndWhereTheirSignalIsIgnored) {
  folder_.write("ball.json", R"({"scenes": [{"file": "ball.pbrt", "reference": {"passes": 2}}],
    "passes": 2, "threads": 1, "methods": [{"integrator": "vilpath"}]})");
  EXPECT_EQ(shell(folder_, "trap '' CHLD; exec \"$brume\" bench ball.json 2> err"), 1);
  const std::string err = readFile(folder_.path() / "err");
  EXPECT_TRUE(contains(err, "FAILED   ball, vilpath")) << err;
  EXPECT_TRUE(contains(err, "(did you mean 'volpath'?)")) << err;
}

#if !BRUME_ASAN && !BRUME_TSAN
TEST_F(Bench, AMethodWithoutMemoryIsTold) {
  folder_.write("ball.json", R"({"scenes": [{"file": "ball.pbrt", "reference": {"passes": 2}}],
    "passes": 1, "threads": 1, "methods": [{"integrator": "volpath"},
      {"name": "bre", "integrator": "bre:photons=50000000,surfacephotons=0"}]})");
  EXPECT_EQ(shell(folder_, "ulimit -v 600000; exec \"$brume\" bench ball.json 2> err"), 1);
  const std::string err = readFile(folder_.path() / "err");
  EXPECT_TRUE(contains(err, "FAILED   ball, bre, 1 threads, seed 0: out of memory")) << err;
  EXPECT_TRUE(contains(err, "rendered ball, volpath")) << err;
}
#endif

TEST_F(Bench, ShowsOtherRenderersImages) {
  folder_.write("ball.json", config(R"("passes": 2, "threads": 1, "foreign": "others.csv")"));
  ASSERT_EQ(runBrume({{"ball.pbrt", "-o", "other.exr", "--seed", "9"}, folder_.path()}).exitCode,
            0);
  folder_.write("others.csv", "name,scene,seconds,image\n\"Other, 2.0\", ball, 0.5, other.exr\n");
  const ProgramResult result = run();
  ASSERT_EQ(result.exitCode, 0) << result.err;
  const Json curve = results()["scenes"][0]["curves"].back();
  EXPECT_EQ(curve["method"], "Other, 2.0");
  EXPECT_EQ(curve["points"][0]["seconds"], 0.5);
  EXPECT_GT(curve["points"][0]["relmse"], 0);
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {"a,ball,1\n", "others.csv:1: a line is"},
           {"# x\na,ball,soon,o.exr\n", "others.csv:2: 'soon' is not a time"},
           {"a,bell,1,o.exr\n", "others.csv:1: there is no scene \"bell\""},
           {"volpath,ball,1,o.exr\n", "\"volpath\" is the name of a method"}}) {
    folder_.write("others.csv", text);
    EXPECT_TRUE(contains(run().err, message)) << run().err;
  }
}

TEST_F(Bench, AMethodThatFailsDoesNotEndTheOthers) {
  folder_.write("ball.json", R"({"scenes": [{"file": "ball.pbrt", "reference": {"passes": 2}}],
    "passes": 2, "threads": 1,
    "methods": [{"integrator": "volpath"}, {"integrator": "vilpath"}]})");
  const ProgramResult result = run();
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_TRUE(contains(result.err, "FAILED   ball, vilpath")) << result.err;
  const Json curves = results()["scenes"][0]["curves"];
  EXPECT_EQ(curves[0]["points"].size(), 7u);
  EXPECT_TRUE(contains(curves[1]["failure"], "vilpath"));
}

TEST_F(Bench, ScenesWithoutTheBaselineHaveTheirTimes) {
  folder_.write("ball.json", R"({"passes": 4, "threads": 1, "baseline": "single",
    "scenes": [{"file": "ball.pbrt", "reference": {"passes": 40}, "methods": ["volpath"]}],
    "methods": [{"integrator": "volpath"}, {"name": "single", "integrator": ["single", "path"]}]})");
  const ProgramResult result = run();
  ASSERT_EQ(result.exitCode, 0) << result.err;
  const Json times = results()["scenes"][0]["times to error"];
  ASSERT_FALSE(times.empty());
  for (const Json& row : times) {
    EXPECT_EQ(row["method"], "volpath");
    EXPECT_GT(row["seconds"], 0);
    EXPECT_TRUE(row["times faster"].is_null());
  }
}

TEST_F(Bench, ABaselineThatDoesNotGetThereGivesABound) {
  folder_.write("ball.json", R"({"threads": 1,
    "scenes": [{"file": "ball.pbrt", "reference": {"passes": 100}}],
    "methods": [{"integrator": "volpath", "name": "short", "passes": 1},
                {"integrator": "volpath", "name": "long", "passes": 16}]})");
  ASSERT_EQ(run().exitCode, 0);
  const Json times = results()["scenes"][0]["times to error"];
  std::vector<double> targets, reached;
  for (const Json& row : times)
    if (row["method"] == "short") {
      targets.push_back(row["relmse"]);
      if (!row["seconds"].is_null()) reached.push_back(row["relmse"]);
    }
  // 16 times the samples: errors a decade below, of which the short render knows nothing.
  ASSERT_FALSE(reached.empty());
  EXPECT_GT(targets.size(), reached.size());
  EXPECT_TRUE(std::is_sorted(targets.rbegin(), targets.rend()));
  for (const Json& row : times)
    EXPECT_EQ(row["times faster"].is_null(),
              row["relmse"] < reached.back() || row["seconds"].is_null());
}

TEST_F(Bench, UsersFaultsAreNamed) {
  const auto errorOf = [&](const std::string& text) {
    folder_.write("ball.json", text);
    const ProgramResult result = run();
    EXPECT_EQ(result.exitCode, 1) << text;
    return result.err;
  };
  EXPECT_TRUE(contains(errorOf(config(R"("threads": 1)")), "nothing ends method \"volpath\""));
  EXPECT_TRUE(contains(errorOf(config(R"("passes": 1, "basline": "x")")),
                       "unknown key \"basline\" (did you mean 'baseline'?)"));
  EXPECT_TRUE(contains(errorOf(config(R"("passes": 1, "baseline": "volpth")")),
                       "there is no method \"volpth\" (did you mean 'volpath'?)"));
  EXPECT_TRUE(contains(errorOf(R"({"scenes": [], "methods": []})"), "\"scenes\" lists none"));
  EXPECT_TRUE(contains(errorOf(R"({"scenes": [{"file": "ball.pbrt"}]})"),
                       "scenes[0].reference must be given"));
}

}  // namespace
}  // namespace brume::test
