// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/registry.h"

namespace brume {

/// The message for a name that no plugin of the kind has: the nearest spelling and all choices, or
/// what to use instead of a plugin that only PBRT-v2 has.
std::string unknownPlugin(std::string_view kind, std::string_view name,
                          const std::vector<std::string>& choices);

/// The name under which a plugin is registered, for one of PBRT-v2's second names.
std::string_view registeredName(std::string_view kind, std::string_view name);

/// The registered plugin, or a SceneError at `where`.
template <class Interface>
const typename Registry<Interface>::Entry& findPlugin(const std::string& name,
                                                      const SourceLocation& where) {
  const auto* entry = Registry<Interface>::find(registeredName(Interface::kPluginKind, name));
  if (!entry)
    throw SceneError(where,
                     unknownPlugin(Interface::kPluginKind, name, Registry<Interface>::names()));
  return *entry;
}

}  // namespace brume
