// SPDX-License-Identifier: Apache-2.0
#include "core/deferred.h"

#include <map>

#include "core/file_cache.h"

namespace brume {

DeferredFiles& DeferredFiles::of(FileCache& files) {
  return *files.get<std::unique_ptr<DeferredFiles>>(
      "", [] { return std::make_unique<DeferredFiles>(); });
}

void DeferredFiles::loadAll() const {
  for (const DeferredFile* file : list_) file->load();
}

DeferredCounts DeferredFiles::count() const {
  DeferredCounts counts;
  std::map<std::string_view, bool> isRead;
  for (const DeferredFile* file : list_) {
    isRead[file->path()] |= file->isLoaded();
    if (!file->isLoaded()) counts.bytesUnread += file->bytes();
  }
  for (const auto& [path, read] : isRead) ++(read ? counts.read : counts.unread);
  return counts;
}

}  // namespace brume
