// SPDX-License-Identifier: Apache-2.0
#include "transport/even_sky.h"

#include <gtest/gtest.h>

#include "core/io/image.h"
#include "support/make_plugin.h"
#include "support/media_scene.h"
#include "support/run_program.h"
#include "support/volumes.h"

namespace brume {
namespace {

/// A sky whose rows of equal angle have these radiances, from the zenith down; rotated, which must
/// not matter.
std::unique_ptr<Light> sky(const std::vector<float>& rows) {
  const test::TemporaryFolder folder;
  LayeredImage image;
  image.displaySize = {2, static_cast<int>(rows.size())};
  image.dataWindow = {{0, 0}, image.displaySize};
  for (const char* c : {"R", "G", "B"})
    for (const float L : rows) image.channels[c].insert(image.channels[c].end(), 2, L);
  const auto path = folder.path() / "sky.exr";
  writeImage(path, image, PixelPrecision::Float);
  Light::FactoryContext context;
  context.lightToWorld = Transform::rotate(50, {1, 2, 3});
  return test::make<Light>("infinite", {test::string("mapname", path.string())}, context);
}

std::unique_ptr<Light> constantSky(const Rgb& L) {
  return test::make<Light>("infinite", {test::color("L", L)});
}

/// Rows of which the first `bright` are 1, the others 0.
std::vector<float> rowsWith(int bright) {
  std::vector<float> rows(256, 0.f);
  std::fill_n(rows.begin(), bright, 1.f);
  return rows;
}

TEST(EvenSky, MomentOfWhatRandomRaysBring) {
  EXPECT_NEAR(unevenness(*constantSky(Rgb(3, 2, 1))), 1, 1e-6);
  EXPECT_NEAR(unevenness(*sky(std::vector<float>(256, 2.f))), 1, 1e-3);
  // Bright in a share s of the directions alone: 1 / s.
  EXPECT_NEAR(unevenness(*sky(rowsWith(128))), 2, 0.03);
  EXPECT_NEAR(unevenness(*sky(rowsWith(85))), 2 / (1 - std::cos(M_PI * 85 / 256)), 0.2);
  // 1 + cos(theta): 4 / 3.
  std::vector<float> rows;
  for (int i = 0; i < 256; ++i)
    rows.push_back(1 + std::cos(kPi * (static_cast<float>(i) + 0.5f) / 256));
  EXPECT_NEAR(unevenness(*sky(rows)), 4 / 3.0, 0.02);
}

TEST(EvenSky, OnlyConcentratedLightsAreLookedAt) {
  std::vector<std::unique_ptr<Light>> lights;
  lights.push_back(constantSky(Rgb(1)));
  lights.push_back(sky(rowsWith(20)));
  lights.push_back(test::makeDistantLight(Vec3(0, 0, 1), Rgb(1)));
  lights.push_back(constantSky(Rgb(0)));
  lights.push_back(test::makePointLight({Vec3(3, 4, 5), Rgb(1)}));
  const std::vector<const Light*> wanted{lights[1].get(), lights[2].get(), lights[4].get()};
  std::vector<std::unique_ptr<Volume>> volumes;
  volumes.push_back(test::makeHomogeneous({}));
  const Scene scene = test::makeMediaScene(std::move(volumes), std::move(lights));
  EXPECT_EQ(lightsToLookAt(scene), wanted);
}

}  // namespace
}  // namespace brume
