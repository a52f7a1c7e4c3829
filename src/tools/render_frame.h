// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "renderers/render_job.h"

namespace brume {

/// Renders the scene file, which must hold exactly one frame, and writes nothing. Throws
/// SceneError.
RenderResult renderFrame(const std::string& scene, const RenderSettings& settings, Log& log,
                         const std::atomic<bool>& stop,
                         const std::function<void(const RenderResult&)>& snapshot = {});

}  // namespace brume
