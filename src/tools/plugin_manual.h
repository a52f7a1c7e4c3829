// SPDX-License-Identifier: Apache-2.0
// The manual of all plugins, made from their parameter declarations: `brume plugins`,
// docs/plugins.md.
#pragma once

#include <string>

namespace brume {

struct PluginManualOptions {
  std::string name;       ///< of a plugin or of a kind; empty: all of them
  bool markdown = false;  ///< the page docs/plugins.md
};

/// Without a name, one line per plugin (or the whole page in markdown); with one, its parameters
/// with types, units, defaults and ranges. Throws SceneError when nothing has that name.
std::string pluginManual(const PluginManualOptions& options);

}  // namespace brume
