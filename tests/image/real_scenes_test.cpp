// SPDX-License-Identifier: Apache-2.0
// Public PBRT-v2 scenes against the images that PBRT-v2's authors published with them. The scenes
// are no part of the project: they are looked for in $BRUME_PBRT_SCENES, then beside the source.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/io/image.h"
#include "core/log.h"
#include "renderers/render_job.h"
#include "tools/image_metrics.h"

namespace brume {
namespace {

namespace fs = std::filesystem;

std::optional<fs::path> scenesFolder() {
  std::vector<fs::path> places;
  if (const char* given = std::getenv("BRUME_PBRT_SCENES")) places.emplace_back(given);
  places.push_back(fs::path(BRUME_SOURCE_DIR) / ".." / "shared" / "pbrt-v2-scenes");
  for (const fs::path& place : places)
    if (fs::exists(place / "spotfog.pbrt")) return place;
  return std::nullopt;
}

/// One scene, how it is sampled here, and how near it must come.
struct RealScene {
  std::string name;
  int samplesPerPixel = 0;  ///< 0: as the scene says
  int block = 8;            ///< pixels of the published image
  double mean = 0.01;       ///< tolerance for the mean of each channel
  double blocks = 0.03;     ///< tolerance for 95 % of the block means
  std::string reference{};  ///< beside the scenes' folder; empty: the published image
};
void PrintTo(const RealScene& scene, std::ostream* os) { *os << scene.name; }

RgbImage rgbOf(const LayeredImage& image) {
  RgbImage rgb(image.dataWindow.width(), image.dataWindow.height());
  for (std::size_t i = 0; i < rgb.pixels.size(); ++i)
    rgb.pixels[i] = {image.channels.at("R")[i], image.channels.at("G")[i],
                     image.channels.at("B")[i]};
  return rgb;
}

RgbImage render(const fs::path& file, const RealScene& scene) {
  RenderSettings settings;
  if (scene.samplesPerPixel > 0) settings.samplesPerPixel = scene.samplesPerPixel;
  Log::Options options;
  options.capture = true;
  Log log(options);
  RenderResult result;
  parseSceneFile(file.string(), {}, log, [&](SceneDescription description) {
    RenderJob job(std::move(description), settings, log);
    result = job.run(std::atomic<bool>{false}, {});
  });
  for (const Stat fault : {Stat::NanRadiance, Stat::InfiniteRadiance, Stat::NegativeRadiance})
    EXPECT_EQ(result.stats[fault], 0u) << statName(fault);
  return rgbOf(result.image);
}

class RealScenes : public testing::TestWithParam<RealScene> {};

TEST_P(RealScenes, LooksAsPublished) {
  const RealScene& scene = GetParam();
  const auto folder = scenesFolder();
  if (!folder)
    GTEST_SKIP() << "PBRT-v2's scenes are not here: set BRUME_PBRT_SCENES to their folder";
  const RgbImage image = render(*folder / (scene.name + ".pbrt"), scene);
  const fs::path referenceFile = scene.reference.empty()
                                     ? *folder / "images" / (scene.name + ".exr")
                                     : *folder / ".." / "references" / scene.reference;
  if (!fs::exists(referenceFile)) GTEST_SKIP() << referenceFile << " is not here";
  const RgbImage published = readImage(referenceFile.string());

  // A reference of lower resolution is compared with the means over its pixels.
  ASSERT_EQ(image.width % published.width, 0);
  const int factor = image.width / published.width;
  const RgbImage reduced = factor == 1 ? image : blockMeans(image, factor);
  const ImageError error = compareImages(reduced, published);
  const BlockComparison comparison = compareBlocks(reduced, published, scene.block / factor);
  fmt::print("{}: mean ratio {:.4f} {:.4f} {:.4f}; 95 % of the blocks within {:.2f} %\n",
             scene.name, error.meanRatio[0], error.meanRatio[1], error.meanRatio[2],
             100 * comparison.quantile(0.95));
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(error.meanRatio[static_cast<std::size_t>(c)], 1.0, scene.mean) << "channel " << c;
  EXPECT_GE(comparison.fractionWithin(scene.blocks), 0.95);
  EXPECT_EQ(error.nonFinitePixels, 0u);
}

std::string testName(const testing::TestParamInfo<RealScene>& info) {
  std::string name = info.param.name + (info.param.reference.empty() ? "" : "_reference");
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(c); }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Quick, RealScenes,
                         testing::Values(RealScene{"spheres-differentials-texfilt"},
                                         RealScene{"teapot-area-light"}),
                         testName);

INSTANTIATE_TEST_SUITE_P(
    Full, RealScenes,
    testing::Values(RealScene{"spotfog", 4}, RealScene{"smoke-2", 4},
                    RealScene{"spotfog", 4, 20, 0.005, 0.02, "spotfog-single-200x150.exr"},
                    RealScene{"smoke-2", 4, 16, 0.005, 0.02, "smoke-2-single-200x200.exr"},
                    RealScene{"killeroo-simple", 4}, RealScene{"room-path", 64},
                    RealScene{"anim-bluespheres", 16}, RealScene{"bump-sphere", 1},
                    RealScene{"arcsphere", 1}),
    testName);

}  // namespace
}  // namespace brume
