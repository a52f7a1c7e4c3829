// SPDX-License-Identifier: Apache-2.0
// Every scene of scenes/ renders, here at 16 x 16, without a warning and to an image that is not
// black.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/io/image.h"
#include "support/folders.h"
#include "support/run_program.h"

namespace brume::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> sceneNames() {
  std::vector<std::string> names;
  const fs::path scenes = test::sourceFolder() / "scenes";
  for (const char* folder : {".", "report"})
    for (const auto& entry : fs::directory_iterator(scenes / folder))
      if (entry.path().extension() == ".pbrt")
        names.push_back((fs::path(folder) / entry.path().stem()).lexically_normal().string());
  std::sort(names.begin(), names.end());
  return names;
}

class Scenes : public ::testing::TestWithParam<std::string> {};

TEST_P(Scenes, RendersSmall) {
  const TemporaryFolder folder;
  const fs::path scene = test::sourceFolder() / "scenes" / (GetParam() + ".pbrt");
  const ProgramResult result = runBrume(
      {{scene.string(), "--resolution", "16x16", "--spp", "4", "--passes", "1", "--strict"},
       folder.path()});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  const std::string name = fs::path(GetParam()).filename().string() + ".exr";
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

INSTANTIATE_TEST_SUITE_P(All, Scenes, ::testing::ValuesIn(sceneNames()), [](const auto& scene) {
  std::string name = scene.param;
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
});

}  // namespace
}  // namespace brume::test
