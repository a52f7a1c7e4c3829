// SPDX-License-Identifier: Apache-2.0
// JSON files that people write, read strictly. The one header that knows nlohmann-json; what is
// written keeps the order in which it was put together.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace brume {

using Json = nlohmann::ordered_json;

/// The file's value. Comments (// and /* */) are allowed. Throws SceneError with line and column.
Json readJsonFile(const std::string& path);
/// The text of a value, for a file. Text that may hold any bytes (file names) never makes it fail.
std::string jsonText(const Json& json);

/// One object of a file, read key by key. Throws SceneError, with the path to the object in its
/// text, for values of a wrong type and for keys that nobody has asked for.
class JsonObject {
 public:
  /// `file` and the `path` to the object in it ("scenes.fog"; empty: the file's own value) name it
  /// in messages. The value outlives the object.
  JsonObject(const Json& json, std::string file, std::string path = {});

  bool has(const std::string& key) const { return json_->contains(key); }
  /// A value, or null, for readers of their own.
  const Json* any(const std::string& key);
  std::optional<bool> boolean(const std::string& key);
  std::optional<std::string> string(const std::string& key);
  /// A finite number in [lo, hi].
  std::optional<double> number(const std::string& key, double lo, double hi);
  std::optional<std::int64_t> whole(const std::string& key, std::int64_t lo, std::int64_t hi);
  /// One string or a list of them; empty when the key is missing.
  std::vector<std::string> strings(const std::string& key);
  /// One whole number or a list of them.
  std::vector<std::int64_t> wholes(const std::string& key, std::int64_t lo, std::int64_t hi);
  /// The objects of a list.
  std::vector<JsonObject> objects(const std::string& key);
  std::optional<JsonObject> object(const std::string& key);
  /// Every key with its object.
  std::vector<std::pair<std::string, JsonObject>> members();

  /// Throws for the first key that nobody has asked for.
  void finish() const;
  [[noreturn]] void fail(const std::string& key, const std::string& wanted) const;
  /// "FILE" or "FILE: scenes.fog".
  std::string where() const { return path_.empty() ? file_ : file_ + ": " + path_; }

 private:
  std::string pathTo(const std::string& key) const;

  const Json* json_;
  std::string file_, path_;
  std::vector<std::string> asked_;
};

}  // namespace brume
