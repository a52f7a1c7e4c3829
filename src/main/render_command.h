// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "main/command_line.h"

namespace brume {

/// Renders every frame of every scene. A scene with an error is reported and the next one follows.
/// Returns the exit code of the process.
int runRender(const RenderCommand& command);

}  // namespace brume
