// SPDX-License-Identifier: Apache-2.0
#include "core/registry.h"

#include <algorithm>

namespace brume {

namespace {

std::vector<const PluginInfo*>& infos() {
  static std::vector<const PluginInfo*> all;
  return all;
}

}  // namespace

void addPluginInfo(const PluginInfo* info) { infos().push_back(info); }

std::vector<const PluginInfo*> allPlugins() {
  std::vector<const PluginInfo*> all = infos();
  std::sort(all.begin(), all.end(), [](const PluginInfo* a, const PluginInfo* b) {
    return a->kind != b->kind ? a->kind < b->kind : a->name < b->name;
  });
  return all;
}

}  // namespace brume
