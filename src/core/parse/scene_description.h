// SPDX-License-Identifier: Apache-2.0
// What the scene language yields: the options of one frame and the world between WorldBegin and
// WorldEnd.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "core/log.h"
#include "core/params.h"
#include "core/scene.h"

namespace brume {

/// A directive that names a plugin, kept until the plugin can be made.
struct PluginDirective {
  std::string name;
  ParamSet params;
};

/// The options block of a frame. Directives that the scene did not give have PBRT-v2's defaults and
/// an unknown location.
struct RenderOptions {
  PluginDirective film{"image", {}};
  PluginDirective filter{"box", {}};
  PluginDirective camera{"perspective", {}};
  PluginDirective sampler{"lowdiscrepancy", {}};
  PluginDirective accelerator{"bvh", {}};
  PluginDirective renderer{"sampler", {}};
  PluginDirective surfaceIntegrator{"directlighting", {}};
  PluginDirective volumeIntegrator{"emission", {}};
  std::optional<PluginDirective> globalIntegrator;
  AnimatedTransform cameraToWorld;  ///< scene space (not yet shifted to render space)
  float transformStart = 0, transformEnd = 1;
  std::string searchDirectory;  ///< relative file names are resolved against it
};

/// One frame, ready to be rendered.
struct SceneDescription {
  RenderOptions options;
  Scene::Contents world;
  /// What the file defines and nothing uses; it was not made (objects: not kept).
  struct Unused {
    std::size_t textures = 0, materials = 0, objects = 0;
  } unused;
};

/// What is wanted from the parser beside the scene.
struct ParseSettings {
  bool quick = false;  ///< --quick
};

/// Parses a scene file ("-": standard input; its relative names are resolved against the working
/// directory) and calls onFrame at each WorldEnd, while the file is still open: several frames
/// render one after another. Throws SceneError at the first error.
void parseSceneFile(const std::string& path, const ParseSettings& settings, Log& log,
                    const std::function<void(SceneDescription)>& onFrame);
/// The same from memory; `name` stands for the file in messages.
void parseSceneText(std::string_view text, const std::string& name,
                    const std::string& searchDirectory, const ParseSettings& settings, Log& log,
                    const std::function<void(SceneDescription)>& onFrame);

}  // namespace brume
