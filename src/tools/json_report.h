// SPDX-License-Identifier: Apache-2.0
// Reports as JSON: --stats and `brume diff --json`.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/stats.h"
#include "renderers/render_job.h"

namespace brume {

/// Seconds spent in the phases of one frame.
struct PhaseTimes {
  double parse = 0, build = 0, render = 0, write = 0;
};

/// What became of one frame.
struct FrameReport {
  std::string scene, image;
  int frame = 1;  ///< its number within the scene file
  Vec2i resolution{0};
  Bounds2i crop;
  std::uint64_t seed = 0;
  int threads = 0, passes = 0, warnings = 0;
  StopReason reason = StopReason::Done;
  PhaseTimes seconds;
  std::uint64_t peakMemory = 0;         ///< of the whole process so far [bytes]
  std::uint64_t acceleratorMemory = 0;  ///< of Embree's structures, without the meshes [bytes]
  std::uint64_t acceleratorPeak = 0;    ///< the most that they took while they were built [bytes]
  Stats stats;
  DeferredCounts files;  ///< of textures and materials
  std::vector<RenderJob::UsedPlugin> plugins;
  std::vector<std::string> plan;  ///< what was built and what was skipped, and why
};

std::string_view toString(StopReason reason);

/// {"brume": version, "frames": [...]}.
std::string statsJson(const std::vector<FrameReport>& frames);
/// The same counters and times for people, grouped.
std::string statsTable(const FrameReport& frame);

/// A flat object of figures for `brume diff`; a figure that is not finite is written as null.
struct FigureList {
  std::map<std::string, std::string> words;
  std::map<std::string, double> numbers;
  std::map<std::string, std::vector<double>> lists;
  std::vector<std::string> failures;  ///< limits that were passed
};
std::string figuresJson(const FigureList& figures);

}  // namespace brume
