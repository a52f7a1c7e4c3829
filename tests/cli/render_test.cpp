// SPDX-License-Identifier: Apache-2.0
// Whole renders through the program: files, exit codes, signals, statistics.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>

#include "core/io/image.h"
#include "support/run_program.h"
#include "support/sanitizers.h"

namespace brume::test {
namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A matte ball in fog under a lamp.
std::string smallScene(const std::string& filename, int spp = 1) {
  return "Film \"image\" \"integer xresolution\" 24 \"integer yresolution\" 16 \"string filename\" "
         "\"" +
         filename +
         "\"\n"
         "Sampler \"random\" \"integer pixelsamples\" " +
         std::to_string(spp) +
         "\n"
         "VolumeIntegrator \"single\"\n"
         "Camera \"perspective\" \"float fov\" 40\n"
         "WorldBegin\n"
         "LightSource \"point\" \"color I\" [20 10 5] \"point from\" [2 2 2]\n"
         "Volume \"homogeneous\" \"color sigma_a\" [.02 .02 .02] \"color sigma_s\" [.05 .05 .05]\n"
         "  \"point p0\" [-4 -4 1] \"point p1\" [4 4 9]\n"
         "Translate 0 0 5\n"
         "Shape \"sphere\"\n"
         "WorldEnd\n";
}

/// Hours of work: to be interrupted.
std::string endlessScene(const std::string& filename) { return smallScene(filename, 1 << 24); }

std::string endOf(const std::string& text) {
  return text.substr(text.size() > 400 ? text.size() - 400 : 0);
}

TEST(Render, WritesTheImageThatTheSceneNames) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", smallScene("ball.exr"));
  const ProgramResult result = runBrume({{"ball.pbrt"}, folder.path()});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  EXPECT_EQ(folder.files(), (std::vector<std::string>{"ball.exr", "ball.pbrt"}));
  const RgbImage image = readImage((folder.path() / "ball.exr").string());
  EXPECT_EQ(image.width, 24);
  EXPECT_EQ(image.height, 16);
  EXPECT_GT(image.at(12, 8).r, image.at(12, 8).b);  // the lamp is reddish
  EXPECT_TRUE(contains(result.err, "wrote ball.exr")) << result.err;
  EXPECT_EQ(result.out, "");
}

TEST(Render, ExtensionChoosesTheFormat) {
  const TemporaryFolder folder;
  for (const std::string extension : {"exr", "png", "pfm", "tga"}) {
    folder.write("ball.pbrt", smallScene("image." + extension));
    const ProgramResult result = runBrume({{"ball.pbrt", "--quiet"}, folder.path()});
    ASSERT_EQ(result.exitCode, 0) << result.err;
    EXPECT_EQ(result.err, "");
    EXPECT_EQ(readImage((folder.path() / ("image." + extension)).string()).width, 24) << extension;
  }
}

TEST(Render, PngBesideTheImage) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", smallScene("ball.exr"));
  const ProgramResult result = runBrume({{"--png", "ball.pbrt"}, folder.path()});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  EXPECT_EQ(folder.files(), (std::vector<std::string>{"ball.exr", "ball.pbrt", "ball.png"}));
}

TEST(Render, UnknownExtensionIsRefusedBeforeRendering) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", endlessScene("image.jpeg2000"));
  const ProgramResult result = runBrume({{"ball.pbrt"}, folder.path()});
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_TRUE(contains(result.err, "image.jpeg2000")) << result.err;
  EXPECT_TRUE(contains(result.err, ".exr")) << result.err;
}

TEST(Render, StandardInput) {
  const TemporaryFolder folder;
  ProgramInput input{{"-"}, folder.path(), smallScene("stdin.exr")};
  const ProgramResult result = runBrume(input);
  ASSERT_EQ(result.exitCode, 0) << result.err;
  EXPECT_EQ(folder.files(), std::vector<std::string>{"stdin.exr"});
}

TEST(Render, SeveralScenesGoOnAfterAFaultyOne) {
  const TemporaryFolder folder;
  folder.write("a.pbrt", smallScene("a.exr"));
  folder.write("bad.pbrt", "Film \"image\"\nWorldBegin\n  Shape \"spere\"\nWorldEnd\n");
  folder.write("c.pbrt", smallScene("c.exr"));
  const ProgramResult result = runBrume({{"a.pbrt", "bad.pbrt", "c.pbrt"}, folder.path()});
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_TRUE(contains(result.err, "bad.pbrt:3:")) << result.err;
  EXPECT_TRUE(contains(result.err, "sphere")) << result.err;
  EXPECT_EQ(folder.files(),
            (std::vector<std::string>{"a.exr", "a.pbrt", "bad.pbrt", "c.exr", "c.pbrt"}));
}

TEST(Render, SecondFrameOfTheSameNameIsWarnedAbout) {
  const TemporaryFolder folder;
  folder.write("two.pbrt", smallScene("same.exr") + smallScene("same.exr"));
  const ProgramResult result = runBrume({{"two.pbrt"}, folder.path()});
  EXPECT_EQ(result.exitCode, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "replaces 'same.exr'")) << result.err;
  EXPECT_EQ(runBrume({{"two.pbrt", "--strict"}, folder.path()}).exitCode, 1);
}

TEST(Render, ASceneWithoutWorldIsAnError) {
  const TemporaryFolder folder;
  folder.write("empty.pbrt", "Film \"image\" \"integer xresolution\" 8\n");
  const ProgramResult result = runBrume({{"empty.pbrt"}, folder.path()});
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_TRUE(contains(result.err, "empty.pbrt")) << result.err;
  EXPECT_TRUE(contains(result.err, "WorldBegin")) << result.err;
}

TEST(Render, CheckReadsAndWritesNothing) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", endlessScene("ball.exr"));
  const ProgramResult result = runBrume({{"--check", "ball.pbrt"}, folder.path()});
  EXPECT_EQ(result.exitCode, 0) << result.err;
  EXPECT_EQ(folder.files(), std::vector<std::string>{"ball.pbrt"});
}

TEST(Render, CheckFindsAWrongValue) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", "Camera \"perspective\" \"float fov\" [40 50]\nWorldBegin\nWorldEnd\n");
  const ProgramResult result = runBrume({{"--check", "ball.pbrt"}, folder.path()});
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_TRUE(contains(result.err, "ball.pbrt:1:")) << result.err;
  EXPECT_TRUE(contains(result.err, "^")) << result.err;
}

TEST(Render, PlanSaysWhatIsThere) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", endlessScene("ball.exr"));
  const ProgramResult result = runBrume({{"--plan", "ball.pbrt"}, folder.path()});
  EXPECT_EQ(result.exitCode, 0) << result.err;
  EXPECT_FALSE(result.out.empty());
  EXPECT_EQ(folder.files(), std::vector<std::string>{"ball.pbrt"});
}

TEST(Render, OptionsReachTheImage) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", smallScene("ball.exr"));
  const ProgramResult result = runBrume(
      {{"ball.pbrt", "--resolution", "40x20", "--crop", "0,0.5,0.5,1", "--variance", "--spp", "4"},
       folder.path()});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  const LayeredImage image = readLayeredImage((folder.path() / "ball.exr").string());
  EXPECT_EQ(image.displaySize, Vec2i(40, 20));
  EXPECT_EQ(image.dataWindow.lo, Vec2i(0, 10));
  EXPECT_EQ(image.dataWindow.hi, Vec2i(20, 20));
  EXPECT_TRUE(image.has("variance.R"));
}

TEST(Render, SameImageForAnyNumberOfThreads) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", smallScene("ball.pfm", 4));
  std::vector<std::string> images;
  for (const char* threads : {"1", "2", "7"}) {
    const ProgramResult result =
        runBrume({{"ball.pbrt", "--threads", threads, "--resolution", "97x61"}, folder.path()});
    ASSERT_EQ(result.exitCode, 0) << result.err;
    images.push_back(readFile(folder.path() / "ball.pfm"));
  }
  EXPECT_EQ(images[0], images[1]);
  EXPECT_EQ(images[0], images[2]);
  ASSERT_EQ(
      runBrume({{"ball.pbrt", "--seed", "1", "--resolution", "97x61"}, folder.path()}).exitCode, 0);
  EXPECT_NE(images[0], readFile(folder.path() / "ball.pfm"));
}

TEST(Render, StatisticsSayWhatWasDone) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", smallScene("ball.exr", 4));
  const ProgramResult result = runBrume(
      {{"ball.pbrt", "--stats", "stats.json", "--seed", "7", "--threads", "2"}, folder.path()});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  const auto json = nlohmann::json::parse(readFile(folder.path() / "stats.json"));
  ASSERT_EQ(json["frames"].size(), 1u);
  const auto& frame = json["frames"][0];
  EXPECT_EQ(frame["image"], "ball.exr");
  EXPECT_EQ(frame["seed"], 7);
  EXPECT_EQ(frame["threads"], 2);
  EXPECT_EQ(frame["stopped"], "done");
  EXPECT_EQ(frame["resolution"], (std::vector<int>{24, 16}));
  EXPECT_GE(frame["counters"]["Rays/camera"], 24 * 16 * 4);
  EXPECT_EQ(frame["counters"]["Faults/NaN radiance"], 0);
  EXPECT_GT(frame["peak memory"], 1 << 20);
  EXPECT_GT(frame["accelerator memory"], 0);
  EXPECT_LE(frame["accelerator memory"], frame["accelerator peak memory"]);
  EXPECT_LT(frame["accelerator peak memory"], frame["peak memory"]);
  for (const char* phase : {"parse", "build", "render", "write"})
    EXPECT_GE(frame["seconds"][phase], 0) << phase;
  const auto isSampler = [](const auto& plugin) {
    return plugin["kind"] == "Sampler" && plugin["name"] == "random" &&
           plugin["parameters"]["integer pixelsamples"] == "4";
  };
  EXPECT_TRUE(std::any_of(frame["plugins"].begin(), frame["plugins"].end(), isSampler));
}

TEST(Render, VerboseEndsWithTheTable) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", smallScene("ball.exr"));
  const ProgramResult result = runBrume({{"ball.pbrt", "--verbose"}, folder.path()});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "Statistics")) << result.err;
  EXPECT_TRUE(contains(result.err, "peak memory")) << result.err;
}

TEST(Render, TimeLimitStops) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", smallScene("ball.exr"));
  const ProgramResult result =
      runBrume({{"ball.pbrt", "--time", "0.3s", "--stats", "stats.json"}, folder.path()});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  const auto json = nlohmann::json::parse(readFile(folder.path() / "stats.json"));
  EXPECT_EQ(json["frames"][0]["stopped"], "time");
  EXPECT_GT(json["frames"][0]["passes"], 1);
  EXPECT_LT(result.seconds, 20);  // wide: the machine may be busy
}

class Signals : public ::testing::TestWithParam<int> {};

TEST_P(Signals, LeaveAReadableImage) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", endlessScene("ball.exr"));
  ProgramInput input{{"ball.pbrt", "--verbose"}, folder.path()};
  input.signal = GetParam();
  input.waitFor = "rendering";
  const ProgramResult result = runBrume(input);
  EXPECT_EQ(result.exitCode, 128 + GetParam()) << endOf(result.err);
  EXPECT_EQ(folder.files(), (std::vector<std::string>{"ball.exr", "ball.pbrt"}));
  const RgbImage image = readImage((folder.path() / "ball.exr").string());
  EXPECT_EQ(image.width, 24);
  // On a busy machine the signal comes before the first sample.
  const bool isBlack =
      contains(result.err, "interrupted before the first pass was done; wrote a black ball.exr");
  for (const Rgb& pixel : image.pixels) {
    ASSERT_TRUE(std::isfinite(pixel.r));
    ASSERT_TRUE(!isBlack || pixel.isBlack());
  }
  EXPECT_TRUE(isBlack || contains(result.err, "interrupted; wrote ball.exr")) << endOf(result.err);
}

TEST(Render, PhotonMapsKeepToTheTimeLimit) {
  // A hundred million photons take minutes.
  const TemporaryFolder folder;
  folder.write("far.pbrt",
               "Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8\n"
               "LookAt 0 0 -4 0 0 0 0 1 0 WorldBegin\n"
               "Volume \"homogeneous\" \"color sigma_s\" [5 5 5] \"point p0\" [-1 -1 -1]\n"
               "LightSource \"point\" \"color I\" [20 20 20] \"point from\" [0 4 0]\n"
               "Shape \"disk\" \"float radius\" .1 WorldEnd\n");
  const ProgramResult result = runBrume(
      {{"far.pbrt", "--integrator", "bre:photons=100000000", "--time", "4s", "-o", "far.exr"},
       folder.path()});
  EXPECT_EQ(result.exitCode, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "--time leaves room for")) << result.err;
#if !BRUME_ASAN
  EXPECT_LT(result.seconds, 12) << result.err;
#endif
}

TEST(Render, ErrorLimitsNeedNoRoomForVariances) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", smallScene("ball.exr"));
  const ProgramResult result =
      runBrume({{"ball.pbrt", "--error", "0.5", "--strict", "-o", "ball.png"}, folder.path()});
  EXPECT_EQ(result.exitCode, 0) << result.err;
  EXPECT_FALSE(contains(result.err, "variance")) << result.err;
  const ProgramResult asked =
      runBrume({{"ball.pbrt", "--variance", "-o", "ball.png"}, folder.path()});
  EXPECT_TRUE(contains(asked.err, "the variance is not written")) << asked.err;
}

TEST(Render, WhatHalvesCannotHoldIsSaid) {
  const TemporaryFolder folder;
  const auto sky = [&](const std::string& L, const std::string& precision) {
    folder.write("sky.pbrt",
                 "Film \"image\" \"integer xresolution\" 4 \"integer yresolution\" 4\n"
                 "\"bool variance\" \"true\" \"string precision\" \"" +
                     precision +
                     "\"\n"
                     "Sampler \"random\" \"integer pixelsamples\" 4 WorldBegin\n"
                     "LightSource \"infinite\" \"color L\" " +
                     L + " WorldEnd\n");
    const ProgramResult result = runBrume({{"sky.pbrt", "-o", "sky.exr"}, folder.path()});
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return result.err;
  };
  EXPECT_TRUE(
      contains(sky("[1e20 1 1]", "half"), "16 pixels of 'sky.exr' are brighter than 65504"));
  const LayeredImage image = readLayeredImage((folder.path() / "sky.exr").string());
  for (const float v : image.channels.at("variance.R")) EXPECT_TRUE(std::isfinite(v)) << v;
  EXPECT_TRUE(contains(sky("[1e-20 0 0]", "half"), "all values of 'sky.exr' are so small"));
  EXPECT_FALSE(contains(sky("[1 2 3]", "half"), "warning"));
  EXPECT_FALSE(contains(sky("[1e20 1 1]", "float"), "warning"));
}

TEST(Render, SaysThatNothingWasRenderedYet) {
  const TemporaryFolder folder;
  folder.write(
      "fog.pbrt",
      "Film \"image\" \"integer xresolution\" 24 \"integer yresolution\" 24\n"
      "GlobalIntegrator \"bre\" \"integer photons\" 1000000000 WorldBegin\n"
      "LightSource \"point\" Volume \"homogeneous\" \"color sigma_s\" [.1 .1 .1] WorldEnd\n");
  ProgramInput input{{"fog.pbrt", "--verbose", "-o", "fog.exr"}, folder.path()};
  input.signal = SIGINT;
  input.waitFor = "rendering";
  const ProgramResult result = runBrume(input);
  EXPECT_EQ(result.exitCode, 128 + SIGINT) << endOf(result.err);
  EXPECT_EQ(readImage((folder.path() / "fog.exr").string()).width, 24);
  EXPECT_TRUE(contains(result.err, "before the first pass was done; wrote a black fog.exr"))
      << endOf(result.err);
}

INSTANTIATE_TEST_SUITE_P(Both, Signals, ::testing::Values(SIGINT, SIGTERM));

TEST(Render, UnwritablePlacesAreFoundBeforeRendering) {
  const TemporaryFolder folder;
  folder.write("file", "not a folder");
  for (const std::string place : {"no/such/folder/ball.exr", "file/ball.exr", "/proc/ball.exr"}) {
    folder.write("ball.pbrt", endlessScene(place));
    const ProgramResult result = runBrume({{"ball.pbrt"}, folder.path()});
    EXPECT_EQ(result.exitCode, 1) << place;
    EXPECT_TRUE(contains(result.err, place)) << result.err;
  }
  folder.write("ball.pbrt", endlessScene("ball.exr"));
  EXPECT_EQ(runBrume({{"ball.pbrt", "--stats", "no/stats.json"}, folder.path()}).exitCode, 1);
  EXPECT_EQ(folder.files(), (std::vector<std::string>{"ball.pbrt", "file"}));
}

TEST(Render, AFullDiskLeavesNoHalfFile) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", smallScene("ball.pfm"));
  ProgramInput input{{"ball.pbrt", "--resolution", "200x200"}, folder.path()};
  input.fileSizeLimit = 20000;  // the image takes 480 000 bytes
  const ProgramResult result = runBrume(input);
  EXPECT_EQ(result.exitCode, 1) << result.err;
  EXPECT_TRUE(contains(result.err, "ball.pfm")) << result.err;
  EXPECT_EQ(folder.files(), std::vector<std::string>{"ball.pbrt"});
}

#if !BRUME_ASAN && !BRUME_TSAN  // they keep what is freed
TEST(Render, MemoryDoesNotGrowWithPasses) {
  const TemporaryFolder folder;
  folder.write("fog.pbrt",
               "LookAt 0 0 -4 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 40\n"
               "Film \"image\" \"integer xresolution\" 48 \"integer yresolution\" 48\n"
               "GlobalIntegrator \"pvpm\" \"integer photonsperpass\" 1000 WorldBegin\n"
               "LightSource \"point\" \"color I\" [2 2 2]\n"
               "Volume \"homogeneous\" \"color sigma_s\" [2 2 2] \"point p0\" [-1 -1 -1]\n"
               "Shape \"sphere\" \"float radius\" .3 WorldEnd\n");
  const auto peakAfter = [&](const std::string& passes) {
    const ProgramResult result = runBrume({{"fog.pbrt", "--threads", "2", "--passes", passes, "-o",
                                            "fog.exr", "--stats", "stats.json"},
                                           folder.path()});
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return nlohmann::json::parse(readFile(folder.path() / "stats.json"))["frames"][0]["peak memory"]
        .get<double>();
  };
  // Quiet runs differ by 2 %; tasks of a busy machine overlap by chance. An arena for each parallel
  // loop gave 20 to 60 % here.
  const double few = peakAfter("10"), many = peakAfter("400");
  EXPECT_LT(many, 1.08 * few) << few << " " << many;
}
#endif

TEST(Render, StartsFast) {
  const TemporaryFolder folder;
  folder.write("ball.pbrt", smallScene("ball.exr"));
  double best = 1e9;
  for (int i = 0; i < 5; ++i)
    best = std::min(best, runBrume({{"--check", "ball.pbrt"}, folder.path()}).seconds);
#if BRUME_ASAN
  constexpr double kLimit = 2;
#else
  constexpr double kLimit = 0.25;  // 0.05 is the goal; the machine may be busy
#endif
  EXPECT_LT(best, kLimit);
}

}  // namespace
}  // namespace brume::test
