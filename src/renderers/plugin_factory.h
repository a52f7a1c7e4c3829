// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/log.h"
#include "core/parse/find_plugin.h"
#include "core/parse/scene_description.h"
#include "core/registry.h"
#include "renderers/render_job.h"

namespace brume {

/// Makes the plugins that the options block names, and keeps the list of them.
class PluginFactory {
 public:
  PluginFactory(std::string searchDirectory, Log& log)
      : searchDirectory_(std::move(searchDirectory)), log_(log) {}

  /// Throws SceneError for an unknown name or a bad parameter. `context` gets its where and log
  /// here.
  template <class Interface>
  std::unique_ptr<Interface> make(PluginDirective& directive,
                                  typename Interface::FactoryContext context) {
    const auto& entry = findPlugin<Interface>(directive.name, directive.params.where());
    ParamReader reader({&directive.params}, directive.name, searchDirectory_, nullptr, log_);
    context.where = directive.params.where();
    context.log = &log_;
    RenderJob::UsedPlugin used{std::string(Interface::kPluginKind), directive.name, {}};
    std::unique_ptr<Interface> plugin = entry.create(reader, context, &used.params);
    reportUnusedParams(directive.params, directive.name, entry.origin, reader.declared(), log_);
    used_.push_back(std::move(used));
    return plugin;
  }

  std::vector<RenderJob::UsedPlugin> takeUsed() { return std::move(used_); }

 private:
  std::string searchDirectory_;
  Log& log_;
  std::vector<RenderJob::UsedPlugin> used_;
};

}  // namespace brume
