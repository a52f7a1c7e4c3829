// SPDX-License-Identifier: Apache-2.0
// Words of PBRT-v2's language that stand for no plugin of that name here: second names, parts that
// brume does not have, accelerators.
#pragma once

#include <string>
#include <string_view>

#include "core/io/source_file.h"
#include "core/log.h"
#include "core/params.h"
#include "core/registry.h"

namespace brume {

/// The name under which a plugin is registered: "area" is "diffuse", "exinfinite" is "infinite".
std::string_view canonicalName(std::string_view kind, std::string_view name);

/// For names that PBRT-v2 has and brume has not: what to use instead ("use ..."); else empty.
std::string_view adviceForAbsent(std::string_view kind, std::string_view name);

/// The message for a name that no plugin of the kind has.
std::string unknownPlugin(std::string_view kind, std::string_view name,
                          const std::vector<std::string>& choices);

/// The registered plugin, or a SceneError at `where`.
template <class Interface>
const typename Registry<Interface>::Entry& findPlugin(const std::string& name,
                                                      const SourceLocation& where) {
  const auto* entry = Registry<Interface>::find(name);
  if (!entry) entry = Registry<Interface>::find(canonicalName(Interface::kPluginKind, name));
  if (!entry)
    throw SceneError(where,
                     unknownPlugin(Interface::kPluginKind, name, Registry<Interface>::names()));
  return *entry;
}

/// Checks an Accelerator directive. brume has one accelerator; PBRT-v2's names and parameters are
/// understood and have no effect, which is said with --verbose.
void checkAccelerator(const std::string& name, ParamSet& params, Log& log);

}  // namespace brume
