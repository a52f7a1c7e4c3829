// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace brume {

/// Names with values; what a block changes is undone at its end. Opening a block costs nothing, a
/// change costs one entry.
template <class V>
class ScopedNames {
 public:
  const V* find(const std::string& name) const {
    const auto it = values_.find(name);
    return it == values_.end() ? nullptr : &it->second;
  }
  void set(const std::string& name, V value) {
    if (!blocks_.empty()) {
      const V* before = find(name);
      undo_.push_back({name, before ? std::optional<V>(*before) : std::nullopt});
    }
    values_.insert_or_assign(name, std::move(value));
  }
  void beginBlock() { blocks_.push_back(undo_.size()); }
  void endBlock() {
    for (; undo_.size() > blocks_.back(); undo_.pop_back()) {
      Change& change = undo_.back();
      if (change.before)
        values_.insert_or_assign(change.name, std::move(*change.before));
      else
        values_.erase(change.name);
    }
    blocks_.pop_back();
  }
  std::vector<std::string> names() const {
    std::vector<std::string> result;
    for (const auto& [name, value] : values_) result.push_back(name);
    return result;
  }

 private:
  struct Change {
    std::string name;
    std::optional<V> before;
  };
  std::unordered_map<std::string, V> values_;
  std::vector<Change> undo_;
  std::vector<std::size_t> blocks_;  // size of undo_ when each block began
};

}  // namespace brume
