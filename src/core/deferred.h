// SPDX-License-Identifier: Apache-2.0
// Data of files that are read when they are first looked at: what no ray meets is not read.
#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace brume {

class FileCache;

/// What a file will be made into, and whether that has been done.
class DeferredFile {
 public:
  virtual ~DeferredFile() = default;
  DeferredFile(const DeferredFile&) = delete;
  DeferredFile& operator=(const DeferredFile&) = delete;

  /// Makes it now, if it is not made. Throws what the making throws, at every call the same.
  virtual void load() const = 0;
  virtual bool isLoaded() const = 0;
  const std::string& path() const { return path_; }
  double bytes() const { return bytes_; }  ///< of memory that it takes, once made

 protected:
  DeferredFile(std::string path, double bytes) : path_(std::move(path)), bytes_(bytes) {}

 private:
  std::string path_;
  double bytes_;
};

/// A T that the first get() makes; other threads that ask meanwhile wait for it. What `make` does
/// must not depend on the thread, and must not run parallel loops: a thread that waits inside of
/// one could be given the work that it waits for.
template <class T>
class Deferred final : public DeferredFile {
 public:
  Deferred(std::string path, double bytes, std::function<T()> make)
      : DeferredFile(std::move(path), bytes), make_(std::move(make)) {}

  const T& get() const {
    if (const T* made = made_.load(std::memory_order_acquire)) [[likely]]
      return *made;
    return makeOnce();
  }
  void load() const override { get(); }
  bool isLoaded() const override { return made_.load(std::memory_order_acquire) != nullptr; }

 private:
  const T& makeOnce() const {
    const std::lock_guard lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
    if (!value_) try {
        value_ = std::make_unique<const T>(make_());
        make_ = nullptr;
        made_.store(value_.get(), std::memory_order_release);
      } catch (...) {
        failure_ = std::current_exception();
        throw;
      }
    return *value_;
  }

  mutable std::atomic<const T*> made_{nullptr};
  mutable std::mutex mutex_;
  mutable std::function<T()> make_;
  mutable std::unique_ptr<const T> value_;
  mutable std::exception_ptr failure_;
};

/// How many files have been made into something, and how many wait in vain so far.
struct DeferredCounts {
  std::size_t read = 0, unread = 0;
  double bytesUnread = 0;  ///< of memory that is not taken
};

/// All deferred files of a scene, in the order in which the scene names them.
class DeferredFiles {
 public:
  /// Those of a cache.
  static DeferredFiles& of(FileCache& files);

  void add(const DeferredFile& file) { list_.push_back(&file); }
  /// Makes all that is not made, as a check.
  void loadAll() const;
  /// A file that is made into several things is read when one of them is made.
  DeferredCounts count() const;

 private:
  std::vector<const DeferredFile*> list_;
};

}  // namespace brume
