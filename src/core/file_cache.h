// SPDX-License-Identifier: Apache-2.0
// What was read from files for one scene: a file that is named twice is read once.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <typeindex>
#include <utility>

namespace brume {

/// Immutable objects by type and key. The scene owns it, so they live as long as what the scene
/// makes of them. Not for several threads at a time.
class FileCache {
 public:
  /// The T under the key, which make() returns when there is none yet. An exception of make()
  /// leaves the key free.
  template <class T, class Make>
  const T& get(const std::string& key, Make&& make) {
    std::unique_ptr<Entry>& entry = entries_[{typeid(T), key}];
    if (!entry) entry = std::make_unique<Held<T>>(make());
    return static_cast<const Held<T>&>(*entry).value;
  }
  /// Forgets all objects of type T, which nothing may look at any more.
  template <class T>
  void drop() {
    std::erase_if(entries_, [](const auto& e) { return e.first.first == typeid(T); });
  }
  std::size_t size() const { return entries_.size(); }

 private:
  struct Entry {
    virtual ~Entry() = default;
  };
  template <class T>
  struct Held final : Entry {
    explicit Held(T&& v) : value(std::move(v)) {}
    const T value;
  };
  std::map<std::pair<std::type_index, std::string>, std::unique_ptr<Entry>> entries_;
};

/// The scene's cache, or one's own where a plugin is made without a scene.
class FileCacheOf {
 public:
  explicit FileCacheOf(FileCache* shared)
      : own_(shared ? nullptr : std::make_unique<FileCache>()), cache_(shared ? *shared : *own_) {}
  FileCache& operator*() { return cache_; }
  FileCache* operator->() { return &cache_; }

 private:
  std::unique_ptr<FileCache> own_;
  FileCache& cache_;
};

}  // namespace brume
