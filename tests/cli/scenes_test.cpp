// SPDX-License-Identifier: Apache-2.0
// Every scene of scenes/ renders, here at 16 x 16, without a warning and to an image that is not
// black.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/io/image.h"
#include "support/run_program.h"

namespace brume::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> sceneNames() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(fs::path(BRUME_SOURCE_DIR) / "scenes"))
    if (entry.path().extension() == ".pbrt") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

class Scenes : public ::testing::TestWithParam<std::string> {};

TEST_P(Scenes, RendersSmall) {
  const TemporaryFolder folder;
  const fs::path scene = fs::path(BRUME_SOURCE_DIR) / "scenes" / (GetParam() + ".pbrt");
  const ProgramResult result = runBrume(
      {{scene.string(), "--resolution", "16x16", "--spp", "4", "--strict"}, folder.path()});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  const std::string name = GetParam() + ".exr";
  ASSERT_EQ(folder.files(), std::vector<std::string>{name})
      << "a scene names its image after itself";
  const RgbImage image = readImage((folder.path() / name).string());
  double sum = 0;
  for (const Rgb& pixel : image.pixels) {
    ASSERT_TRUE(std::isfinite(pixel.r) && std::isfinite(pixel.g) && std::isfinite(pixel.b));
    sum += pixel.r + pixel.g + pixel.b;
  }
  EXPECT_GT(sum, 0);
}

INSTANTIATE_TEST_SUITE_P(All, Scenes, ::testing::ValuesIn(sceneNames()),
                         [](const auto& scene) { return scene.param; });

}  // namespace
}  // namespace brume::test
