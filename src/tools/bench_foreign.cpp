// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "core/error.h"
#include "core/io/file_bytes.h"
#include "tools/bench_entry.h"

namespace brume {
namespace {

constexpr std::uint64_t kMaxCsvBytes = std::uint64_t{64} << 20;
constexpr std::size_t kColumns = 4;

/// The fields of one line: separated by commas, blanks around them dropped, a field in double
/// quotes may hold commas.
std::vector<std::string> splitCsvLine(const std::string& line) {
  std::vector<std::string> fields(1);
  bool isQuoted = false;
  for (const char c : line) {
    if (c == '"')
      isQuoted = !isQuoted;
    else if (c == ',' && !isQuoted)
      fields.emplace_back();
    else
      fields.back() += c;
  }
  for (std::string& field : fields) {
    const std::size_t first = field.find_first_not_of(" \t\r");
    const std::size_t last = field.find_last_not_of(" \t\r");
    field = first == std::string::npos ? "" : field.substr(first, last - first + 1);
  }
  return fields;
}

}  // namespace

std::vector<BenchEntry> readForeignEntries(const std::string& csv, const BenchConfig& config) {
  const Bytes bytes = readFileBytes(csv, kMaxCsvBytes);
  std::vector<std::string> lines(1);
  for (const unsigned char c : bytes)
    if (c == '\n')
      lines.emplace_back();
    else
      lines.back() += static_cast<char>(c);

  std::vector<BenchEntry> entries;
  const auto entryOf = [&](const std::string& method, const std::string& scene) -> BenchEntry& {
    for (BenchEntry& e : entries)
      if (e.method == method && e.scene == scene) return e;
    BenchEntry entry;
    entry.method = method;
    entry.scene = scene;
    return entries.emplace_back(std::move(entry));
  };
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::vector<std::string> fields = splitCsvLine(lines[i]);
    if (fields.front().empty() ? fields.size() == 1 : fields.front()[0] == '#') continue;
    if (i == 0 && fields.front() == "name") continue;
    const auto fail = [&](const std::string& text) {
      throw SceneError(fmt::format("{}:{}: {}", csv, i + 1, text));
    };
    if (fields.size() != kColumns) fail("a line is: name, scene, seconds, image file");
    double seconds = 0;
    const std::string& number = fields[2];
    const auto [end, error] =
        std::from_chars(number.data(), number.data() + number.size(), seconds);
    if (error != std::errc{} || end != number.data() + number.size() || !(seconds > 0))
      fail(fmt::format("'{}' is not a time in seconds", number));
    const auto isScene = [&](const BenchScene& s) { return s.name == fields[1]; };
    if (std::none_of(config.scenes.begin(), config.scenes.end(), isScene))
      fail(fmt::format("there is no scene \"{}\"", fields[1]));
    for (const BenchMethod& method : config.methods)
      if (method.name == fields[0]) fail(fmt::format("\"{}\" is the name of a method", fields[0]));
    BenchPoint point;
    point.seconds = seconds;
    point.image = (std::filesystem::path(csv).parent_path() / fields[3]).string();
    entryOf(fields[0], fields[1]).points.push_back(std::move(point));
  }
  for (BenchEntry& entry : entries)
    std::sort(entry.points.begin(), entry.points.end(),
              [](const BenchPoint& a, const BenchPoint& b) { return a.seconds < b.seconds; });
  return entries;
}

}  // namespace brume
