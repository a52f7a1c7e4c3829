// SPDX-License-Identifier: Apache-2.0
#include <set>

#include "core/error.h"
#include "tools/bench_report.h"
#include "tools/image_metrics.h"
#include "tools/pages.h"
#include "tools/web_page.h"

namespace brume {
namespace {

constexpr std::string_view kDataMark = "/*DATA*/";

/// The last image of each method (its first seed) with its error maps.
Json picturesOf(const BenchedScene& benched, const RgbImage& truth) {
  Json list = Json::array();
  std::set<std::pair<std::string, int>> shown;
  for (const BenchEntry& entry : benched.entries) {
    if (entry.points.empty() || !shown.insert({entry.method, entry.threads}).second) continue;
    const RgbImage image = toRgbImage(readLayeredImage(entry.points.back().image));
    Json picture;
    picture["method"] = entry.method;
    picture["threads"] = entry.threads;
    picture["seconds"] = entry.points.back().seconds;
    picture["image"] = pngUri(image);
    picture["error"] = pngUri(heatmap(relativeErrorMap(image, truth)));
    picture["flip"] = pngUri(heatmap(flip(image, truth).map));
    list.push_back(std::move(picture));
  }
  return list;
}

}  // namespace

std::string benchPage(const Json& results, const std::vector<BenchedScene>& scenes) {
  Json data = results;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (!scenes[i].failure.empty()) continue;
    const RgbImage truth = toRgbImage(readLayeredImage(scenes[i].referenceFile));
    data["scenes"][i]["reference"] = pngUri(truth);
    data["scenes"][i]["pictures"] = picturesOf(scenes[i], truth);
  }
  // Inside a script element nothing but "</" could end it early.
  std::string text = data.dump(-1, ' ', true, Json::error_handler_t::replace);
  for (std::size_t at = text.find("</"); at != std::string::npos; at = text.find("</", at + 3))
    text.insert(at + 1, "\\");
  std::string page(kBenchPage);
  const std::size_t at = page.find(kDataMark);
  BRUME_CHECK(at != std::string::npos);
  return page.replace(at, kDataMark.size(), text);
}

}  // namespace brume
