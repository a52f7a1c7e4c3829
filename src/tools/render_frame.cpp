// SPDX-License-Identifier: Apache-2.0
#include "tools/render_frame.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/log.h"

namespace brume {

RenderResult renderFrame(const std::string& scene, const RenderSettings& settings, Log& log,
                         const std::atomic<bool>& stop,
                         const std::function<void(const RenderResult&)>& snapshot) {
  std::optional<SceneDescription> frame;
  parseSceneFile(scene, ParseSettings{settings.quick}, log, [&](SceneDescription description) {
    if (frame)
      throw SceneError(fmt::format("'{}' holds more than one frame; split it into files", scene));
    frame = std::move(description);
  });
  if (!frame) throw SceneError(fmt::format("'{}' holds no WorldBegin ... WorldEnd", scene));
  RenderJob job(std::move(*frame), settings, log);
  return job.run(stop, {}, snapshot);
}

}  // namespace brume
