// SPDX-License-Identifier: Apache-2.0
// What the user asked for on the command line. The one pair of files that knows CLI11.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/log.h"
#include "renderers/render_job.h"
#include "tools/bench.h"
#include "tools/diff.h"
#include "tools/photon_report.h"
#include "tools/plugin_manual.h"
#include "tools/regress.h"

namespace brume {

/// brume SCENE... [options]
struct RenderCommand {
  enum class Action { Render, Check, Plan };
  std::vector<std::string> scenes;  ///< "-" is standard input
  RenderSettings settings;
  Action action = Action::Render;
  Log::Options log;
  bool pngToo = false;    ///< a PNG beside every image that is not one
  int threads = 0;        ///< 0: as many as the machine has
  std::string statsFile;  ///< empty: none
};

/// brume regress DIR [NAME...]
struct RegressCommand {
  RegressOptions options;
  Log::Options log;
  int threads = 0;  ///< 0: as many as the machine has
};

/// brume bench FILE.json
struct BenchCommand {
  BenchOptions options;
  bool isQuiet = false;
};

/// --help and --version: a text for standard output and nothing else to do.
struct ShowText {
  std::string text;
};

using Command = std::variant<RenderCommand, DiffOptions, PluginManualOptions, PhotonReportOptions,
                             RegressCommand, BenchCommand, ShowText>;

/// Throws SceneError for an option that does not exist, a value that it cannot take or a
/// contradiction.
Command parseCommandLine(int argc, const char* const* argv);

}  // namespace brume
