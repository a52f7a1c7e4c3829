// SPDX-License-Identifier: Apache-2.0
// tests/images holds a scene for every plugin, with references that are small.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "core/camera.h"
#include "core/film.h"
#include "core/integrator.h"
#include "core/light.h"
#include "core/material.h"
#include "core/registry.h"
#include "core/sampler.h"
#include "core/shape.h"
#include "core/texture.h"
#include "core/volume.h"
#include "support/folders.h"

namespace brume {
namespace {

namespace fs = std::filesystem;

const fs::path kFolder = test::sourceFolder() / "tests" / "images";

std::string textOf(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

/// All scenes and what they include.
std::string allScenes() {
  std::string text;
  for (const auto& entry : fs::recursive_directory_iterator(kFolder))
    if (entry.path().extension() == ".pbrt") text += textOf(entry.path());
  return text + textOf(kFolder / "regress.json");
}

template <class Interface>
void expectAllPlugins(const std::string& scenes, const std::set<std::string>& others = {}) {
  for (const std::string& name : Registry<Interface>::names())
    EXPECT_TRUE(others.count(name) == 1 || scenes.find("\"" + name + "\"") != std::string::npos)
        << Interface::kPluginKind << " \"" << name << "\" is in no scene of tests/images";
}

TEST(RegressScenes, CoverEveryPlugin) {
  const std::string scenes = allScenes();
  expectAllPlugins<Shape>(scenes);
  expectAllPlugins<Light>(scenes);
  expectAllPlugins<AreaLight>(scenes, {"area"});  // another name of "diffuse"
  expectAllPlugins<Camera>(scenes);
  expectAllPlugins<Sampler>(scenes);
  expectAllPlugins<Filter>(scenes);
  expectAllPlugins<Film>(scenes);
  expectAllPlugins<Material>(scenes);
  expectAllPlugins<Texture<float>>(scenes);
  expectAllPlugins<Texture<Rgb>>(scenes);
  expectAllPlugins<Volume>(scenes);
  expectAllPlugins<SurfaceIntegrator>(scenes, {"exphotonmap"});  // another name of "photonmap"
  expectAllPlugins<VolumeIntegrator>(scenes);
  expectAllPlugins<GlobalIntegrator>(scenes);
}

TEST(RegressScenes, HaveSmallReferences) {
  constexpr std::uintmax_t kLargest = 200 * 1024;
  std::size_t scenes = 0;
  for (const auto& entry : fs::directory_iterator(kFolder)) {
    if (entry.path().extension() != ".pbrt") continue;
    ++scenes;
    fs::path reference = entry.path();
    reference.replace_extension(".ref.exr");
    ASSERT_TRUE(fs::exists(reference)) << reference << ": make it by brume regress --update";
    EXPECT_LE(fs::file_size(reference), kLargest) << reference;
  }
  EXPECT_GE(scenes, 30u);
}

}  // namespace
}  // namespace brume
