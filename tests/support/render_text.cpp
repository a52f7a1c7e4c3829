// SPDX-License-Identifier: Apache-2.0
#include "support/render_text.h"

#include <gtest/gtest.h>

namespace brume {

std::unique_ptr<RenderJob> makeJob(const std::string& text, const RenderSettings& settings,
                                   Log& log) {
  std::unique_ptr<RenderJob> job;
  parseSceneText(text, "test.pbrt", ".", {}, log, [&](SceneDescription description) {
    if (!job) job = std::make_unique<RenderJob>(std::move(description), settings, log);
  });
  EXPECT_NE(job, nullptr) << "no frame in the scene text";
  return job;
}

RenderResult renderText(const std::string& text, const RenderSettings& settings) {
  Log::Options options;
  options.capture = true;
  Log log(options);
  return makeJob(text, settings, log)->run(std::atomic<bool>{false}, {});
}

Rgb pixelOf(const LayeredImage& image, int x, int y) {
  const Bounds2i& window = image.dataWindow;
  const auto i =
      static_cast<std::size_t>(y - window.lo.y) * static_cast<std::size_t>(window.width()) +
      static_cast<std::size_t>(x - window.lo.x);
  return {image.channels.at("R")[i], image.channels.at("G")[i], image.channels.at("B")[i]};
}

Rgb meanOf(const LayeredImage& image) {
  Rgb mean;
  int c = 0;
  for (const char* name : {"R", "G", "B"}) {
    double sum = 0;
    for (const float v : image.channels.at(name)) sum += v;
    mean[c++] = static_cast<float>(sum / static_cast<double>(image.dataWindow.area()));
  }
  return mean;
}

}  // namespace brume
