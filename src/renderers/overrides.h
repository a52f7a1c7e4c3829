// SPDX-License-Identifier: Apache-2.0
// What the command line changes in the options block of a scene, and what stands in for plugins of
// PBRT-v2 that are not built.
#pragma once

#include "core/parse/scene_description.h"
#include "renderers/render_job.h"

namespace brume {

/// "NAME" or "NAME:key=value,key=value", with values typed as the plugin `info` declares them.
/// Throws SceneError for an unknown key or a value of the wrong type.
PluginDirective parseIntegrator(const std::string& argument);

/// Puts each --integrator in the place of the scene's surface, volume or global one. A global
/// integrator replaces both others; naming a surface or volume integrator drops the scene's global
/// one.
void overrideIntegrators(const std::vector<std::string>& arguments, RenderOptions& options,
                         Log& log);

/// Throws SceneError for PBRT-v2's renderers and integrators that are not built, with what to use
/// instead. A renderer with its own method gives way to an integrator that the command line names.
void refuseUnbuilt(RenderOptions& options, bool integratorGiven, Log& log);

}  // namespace brume
