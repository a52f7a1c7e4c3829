// SPDX-License-Identifier: Apache-2.0
// `brume diff`: figures, limits, formats.
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "core/io/image.h"
#include "support/run_program.h"

namespace brume::test {
namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// 16 x 16 pixels of one value, with a variance for each pixel value when it is positive.
LayeredImage flatImage(float value, float variance = 0) {
  LayeredImage image;
  image.displaySize = {16, 16};
  image.dataWindow = {Vec2i{0}, image.displaySize};
  for (const char* channel : {"R", "G", "B"}) {
    image.channels[channel].assign(256, value);
    if (variance > 0) image.channels[std::string("variance.") + channel].assign(256, variance);
  }
  return image;
}

class Diff : public ::testing::Test {
 protected:
  Diff() {
    write("one.exr", flatImage(1));
    write("less.exr", flatImage(0.9f));
  }
  void write(const std::string& name, const LayeredImage& image) const {
    writeImage((folder_.path() / name).string(), image);
  }
  ProgramResult run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "diff");
    return runBrume({arguments, folder_.path()});
  }
  TemporaryFolder folder_;
};

TEST_F(Diff, EqualImagesPassEveryLimit) {
  const ProgramResult result =
      run({"one.exr", "one.exr", "--max-mse", "0", "--max-relmse", "0", "--max-mae", "0",
           "--min-psnr", "100", "--max-flip", "0", "--max-mean-ratio-error", "0", "--block", "4",
           "--max-block-error", "0"});
  EXPECT_EQ(result.exitCode, 0) << result.out << result.err;
  EXPECT_FALSE(contains(result.out, "FAILED"));
}

TEST_F(Diff, FiguresAreRight) {
  const ProgramResult result = run({"less.exr", "one.exr", "--json"});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  // 0.1 below 1 everywhere; 0.9 is rounded to float, hence 1e-6.
  EXPECT_NEAR(json["mse"], 0.01, 1e-6);
  EXPECT_NEAR(json["relmse"], 0.01 / 1.01, 1e-6);
  EXPECT_NEAR(json["mae"], 0.1, 1e-6);
  EXPECT_NEAR(json["psnr"], 20, 1e-4);
  EXPECT_NEAR(json["mean ratio"][1], 0.9, 1e-6);
  EXPECT_TRUE(json["failures"].empty());
}

TEST_F(Diff, EveryLimitFailsOnItsOwn) {
  for (const auto& [option, limit] :
       std::vector<std::pair<std::string, std::string>>{{"--max-mse", "0.009"},
                                                        {"--max-relmse", "0.009"},
                                                        {"--max-mae", "0.09"},
                                                        {"--min-psnr", "21"},
                                                        {"--max-flip", "1e-6"},
                                                        {"--max-mean-ratio-error", "0.09"}}) {
    const ProgramResult result = run({"less.exr", "one.exr", option, limit});
    EXPECT_EQ(result.exitCode, 1) << option;
    EXPECT_TRUE(contains(result.out, "FAILED")) << option << '\n' << result.out;
  }
  EXPECT_EQ(run({"less.exr", "one.exr", "--max-mse", "0.011"}).exitCode, 0);
  EXPECT_EQ(run({"less.exr", "one.exr", "--block", "8", "--max-block-error", "0.09"}).exitCode, 1);
}

TEST_F(Diff, ZTestUsesTheVariances) {
  write("a.exr", flatImage(1, 0.01f));
  write("near.exr", flatImage(1.05f, 0.01f));  // z = 0.35
  write("far.exr", flatImage(2, 0.01f));       // z = 7
  EXPECT_EQ(run({"near.exr", "a.exr", "--z-test", "0.01"}).exitCode, 0);
  EXPECT_EQ(run({"far.exr", "a.exr", "--z-test", "0.01"}).exitCode, 1);
  const ProgramResult without = run({"one.exr", "less.exr", "--z-test", "0.01"});
  EXPECT_EQ(without.exitCode, 1);
  EXPECT_TRUE(contains(without.err, "variance layers")) << without.err;
}

TEST_F(Diff, NotANumberFailsWhereThereIsALimit) {
  LayeredImage broken = flatImage(1);
  broken.channels["G"][7] = std::numeric_limits<float>::quiet_NaN();
  write("broken.exr", broken);
  const ProgramResult result = run({"broken.exr", "one.exr", "--max-mse", "1"});
  EXPECT_EQ(result.exitCode, 1) << result.out;
  EXPECT_TRUE(contains(result.out, "not finite")) << result.out;
}

TEST_F(Diff, DifferentSizesAreAnError) {
  LayeredImage small = flatImage(1);
  small.displaySize = {8, 32};
  small.dataWindow = {Vec2i{0}, small.displaySize};
  write("small.exr", small);
  const ProgramResult result = run({"small.exr", "one.exr"});
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_EQ(
      result.err,
      "brume: error: the images differ in size: 'small.exr' has 8 x 32 pixels, 'one.exr' 16 x "
      "16\n");
}

TEST_F(Diff, PngIsComparedInLinearLight) {
  write("half.exr", flatImage(0.5f));
  write("half.png", flatImage(0.5f));
  // One step of 8-bit sRGB near 0.5 is 0.006.
  EXPECT_EQ(run({"half.png", "half.exr", "--max-mae", "0.004"}).exitCode, 0);
}

TEST_F(Diff, HeatmapIsAnImageOfTheSameSize) {
  ASSERT_EQ(run({"less.exr", "one.exr", "--heatmap", "heat.png"}).exitCode, 0);
  EXPECT_EQ(readImage((folder_.path() / "heat.png").string()).width, 16);
}

TEST_F(Diff, MissingImageIsNamed) {
  const ProgramResult result = run({"none.exr", "one.exr"});
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_TRUE(contains(result.err, "none.exr")) << result.err;
}

}  // namespace
}  // namespace brume::test
