// SPDX-License-Identifier: Apache-2.0
#include "tools/json_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/version.h"
#include "tools/json_object.h"

namespace brume {
namespace {

/// Calls f(group, name, value) for each counter, group after group in order of declaration.
template <class F>
void forEachCounter(const Stats& stats, F&& f) {
  std::vector<std::string_view> groups;
  const auto groupOf = [](std::string_view name) { return name.substr(0, name.find('/')); };
  for (std::size_t i = 0; i < static_cast<std::size_t>(Stat::Count); ++i) {
    const std::string_view group = groupOf(statName(static_cast<Stat>(i)));
    if (std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
  }
  for (const std::string_view group : groups)
    for (std::size_t i = 0; i < static_cast<std::size_t>(Stat::Count); ++i) {
      const std::string_view name = statName(static_cast<Stat>(i));
      if (groupOf(name) == group)
        f(group, name.substr(group.size() + 1), stats[static_cast<Stat>(i)]);
    }
}

Json pluginJson(const RenderJob::UsedPlugin& plugin) {
  Json params = Json::object();
  for (const ParamRecord& record : plugin.params)
    if (record.type != "alias") params[record.type + " " + record.name] = record.value;
  return {{"kind", plugin.kind}, {"name", plugin.name}, {"parameters", std::move(params)}};
}

Json frameJson(const FrameReport& frame) {
  Json json;
  json["scene"] = frame.scene;
  json["frame"] = frame.frame;
  json["image"] = frame.image;
  json["resolution"] = {frame.resolution.x, frame.resolution.y};
  json["crop"] = {frame.crop.lo.x, frame.crop.hi.x, frame.crop.lo.y, frame.crop.hi.y};
  json["seed"] = frame.seed;
  json["threads"] = frame.threads;
  json["passes"] = frame.passes;
  json["stopped"] = toString(frame.reason);
  json["warnings"] = frame.warnings;
  json["seconds"] = {{"parse", frame.seconds.parse},
                     {"build", frame.seconds.build},
                     {"render", frame.seconds.render},
                     {"write", frame.seconds.write}};
  json["peak memory"] = frame.peakMemory;
  json["accelerator memory"] = frame.acceleratorMemory;
  json["accelerator peak memory"] = frame.acceleratorPeak;
  Json& counters = json["counters"] = Json::object();
  forEachCounter(frame.stats, [&](std::string_view group, std::string_view name, std::uint64_t n) {
    counters[fmt::format("{}/{}", group, name)] = n;
  });
  counters["Files/read"] = frame.files.read;
  counters["Files/not read"] = frame.files.unread;
  json["plan"] = frame.plan;
  Json& plugins = json["plugins"] = Json::array();
  for (const RenderJob::UsedPlugin& plugin : frame.plugins) plugins.push_back(pluginJson(plugin));
  return json;
}

}  // namespace

std::string_view toString(StopReason reason) {
  switch (reason) {
    case StopReason::Done:
      return "done";
    case StopReason::Time:
      return "time";
    case StopReason::Error:
      return "error";
    case StopReason::Interrupted:
      return "interrupted";
  }
  return "";
}

std::string statsJson(const std::vector<FrameReport>& frames) {
  Json json;
  json["brume"] = version();
  Json& list = json["frames"] = Json::array();
  for (const FrameReport& frame : frames) list.push_back(frameJson(frame));
  return jsonText(json);
}

std::string statsTable(const FrameReport& frame) {
  std::string text = "Statistics\n";
  const auto row = [&text](std::string_view name, const std::string& value) {
    text += fmt::format("    {:<24}{:>16}\n", name, value);
  };
  std::string_view shownGroup;
  forEachCounter(frame.stats, [&](std::string_view group, std::string_view name, std::uint64_t n) {
    if (n == 0) return;
    if (group != shownGroup) text += fmt::format("  {}\n", group);
    shownGroup = group;
    row(name, fmt::format("{}", n));
  });
  if (frame.files.read + frame.files.unread > 0) {
    text += "  Files\n";
    row("read", fmt::format("{}", frame.files.read));
    row("not read", fmt::format("{}", frame.files.unread));
  }
  text += "  Time [s]\n";
  const PhaseTimes& t = frame.seconds;
  for (const auto& [name, seconds] : {std::pair{"parse", t.parse}, std::pair{"build", t.build},
                                      std::pair{"render", t.render}, std::pair{"write", t.write}})
    row(name, fmt::format("{:.3f}", seconds));
  text += "  Process\n";
  row("threads", fmt::format("{}", frame.threads));
  const auto mebibytes = [](std::uint64_t n) {
    return fmt::format("{:.1f}", double(n) / (1 << 20));
  };
  row("peak memory [MiB]", mebibytes(frame.peakMemory));
  row("accelerator [MiB]", mebibytes(frame.acceleratorMemory));
  return text;
}

std::string figuresJson(const FigureList& figures) {
  Json json;
  for (const auto& [name, word] : figures.words) json[name] = word;
  for (const auto& [name, value] : figures.numbers) json[name] = value;
  for (const auto& [name, list] : figures.lists) json[name] = list;
  json["failures"] = figures.failures;
  return jsonText(json);
}

}  // namespace brume
