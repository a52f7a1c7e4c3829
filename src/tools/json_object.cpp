// SPDX-License-Identifier: Apache-2.0
#include "tools/json_object.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/io/file_bytes.h"
#include "core/log.h"

namespace brume {
namespace {

/// A file of settings that is larger than this was meant for something else.
constexpr std::uint64_t kMaxJsonBytes = std::uint64_t{64} << 20;

}  // namespace

Json readJsonFile(const std::string& path) {
  const Bytes bytes = readFileBytes(path, kMaxJsonBytes);
  try {
    return Json::parse(bytes.begin(), bytes.end(), nullptr, true, true);
  } catch (const Json::parse_error& error) {
    // The library counts bytes from 1; people count lines.
    const std::size_t at = std::min(bytes.size(), error.byte > 0 ? error.byte - 1 : 0);
    const auto end = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    const auto line = 1 + std::count(bytes.begin(), end, '\n');
    const auto lineStart = std::find(std::make_reverse_iterator(end), bytes.rend(), '\n').base();
    const std::string text = error.what();
    const std::size_t detail = text.find("syntax error");
    throw SceneError(fmt::format("{}:{}:{}: this is not JSON: {}", path, line,
                                 1 + (end - lineStart),
                                 detail == std::string::npos ? text : text.substr(detail)));
  }
}

std::string jsonText(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

JsonObject::JsonObject(const Json& json, std::string file, std::string path)
    : json_(&json), file_(std::move(file)), path_(std::move(path)) {
  if (!json.is_object()) throw SceneError(fmt::format("{} must be an object {{...}}", where()));
}

std::string JsonObject::pathTo(const std::string& key) const {
  return path_.empty() ? key : fmt::format("{}.{}", path_, key);
}

void JsonObject::fail(const std::string& key, const std::string& wanted) const {
  throw SceneError(fmt::format("{}: {} must be {}", file_, pathTo(key), wanted));
}

const Json* JsonObject::any(const std::string& key) {
  asked_.push_back(key);
  const auto it = json_->find(key);
  return it == json_->end() ? nullptr : &*it;
}

std::optional<bool> JsonObject::boolean(const std::string& key) {
  const Json* value = any(key);
  if (!value) return std::nullopt;
  if (!value->is_boolean()) fail(key, "true or false");
  return value->get<bool>();
}

std::optional<std::string> JsonObject::string(const std::string& key) {
  const Json* value = any(key);
  if (!value) return std::nullopt;
  if (!value->is_string() || value->get<std::string>().empty()) fail(key, "a string");
  return value->get<std::string>();
}

std::optional<double> JsonObject::number(const std::string& key, double lo, double hi) {
  const Json* value = any(key);
  if (!value) return std::nullopt;
  const double x = value->is_number() ? value->get<double>() : std::nan("");
  if (!(x >= lo && x <= hi)) fail(key, fmt::format("a number from {} to {}", lo, hi));
  return x;
}

std::optional<std::int64_t> JsonObject::whole(const std::string& key, std::int64_t lo,
                                              std::int64_t hi) {
  const Json* value = any(key);
  if (!value) return std::nullopt;
  const bool isWhole = value->is_number_integer();
  if (!isWhole || value->get<std::int64_t>() < lo || value->get<std::int64_t>() > hi)
    fail(key, fmt::format("a whole number from {} to {}", lo, hi));
  return value->get<std::int64_t>();
}

std::vector<std::string> JsonObject::strings(const std::string& key) {
  const Json* value = any(key);
  if (!value) return {};
  if (value->is_string()) return {value->get<std::string>()};
  std::vector<std::string> list;
  if (!value->is_array()) fail(key, "a string or a list of strings");
  for (const Json& item : *value) {
    if (!item.is_string()) fail(key, "a string or a list of strings");
    list.push_back(item.get<std::string>());
  }
  return list;
}

std::vector<std::int64_t> JsonObject::wholes(const std::string& key, std::int64_t lo,
                                             std::int64_t hi) {
  const Json* value = any(key);
  if (!value) return {};
  const auto read = [&](const Json& item) {
    if (!item.is_number_integer() || item.get<std::int64_t>() < lo || item.get<std::int64_t>() > hi)
      fail(key, fmt::format("a whole number from {} to {}, or a list of such", lo, hi));
    return item.get<std::int64_t>();
  };
  if (!value->is_array()) return {read(*value)};
  std::vector<std::int64_t> list;
  for (const Json& item : *value) list.push_back(read(item));
  return list;
}

std::vector<JsonObject> JsonObject::objects(const std::string& key) {
  const Json* value = any(key);
  if (!value) return {};
  if (!value->is_array()) fail(key, "a list of objects");
  std::vector<JsonObject> list;
  for (std::size_t i = 0; i < value->size(); ++i)
    list.emplace_back((*value)[i], file_, fmt::format("{}[{}]", pathTo(key), i));
  return list;
}

std::optional<JsonObject> JsonObject::object(const std::string& key) {
  const Json* value = any(key);
  if (!value) return std::nullopt;
  return JsonObject(*value, file_, pathTo(key));
}

std::vector<std::pair<std::string, JsonObject>> JsonObject::members() {
  std::vector<std::pair<std::string, JsonObject>> list;
  for (const auto& [key, value] : json_->items()) {
    asked_.push_back(key);
    list.emplace_back(key, JsonObject(value, file_, pathTo(key)));
  }
  return list;
}

void JsonObject::finish() const {
  for (const auto& [key, value] : json_->items())
    if (std::find(asked_.begin(), asked_.end(), key) == asked_.end())
      throw SceneError(fmt::format("{}: unknown key \"{}\"{}; the keys are {}", where(), key,
                                   nearestSpelling(key, asked_), listChoices(asked_)));
}

}  // namespace brume
