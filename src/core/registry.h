// SPDX-License-Identifier: Apache-2.0
// The registry of plugins, brume's only global. A plugin registers itself with one line in its
// .cpp:
//
//   const RegisterPlugin<Shape, Sphere> kRegistration{"sphere", Origin::PbrtV2, "sphere or part of
//   one"};
//
// where Sphere has `struct Params` with visit() and a constructor Sphere(Params, const
// Shape::FactoryContext&).
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/params.h"

namespace brume {

/// What every kind of plugin tells of itself.
struct PluginInfo {
  std::string_view kind;  ///< "Shape", "LightSource", ...: the directive that names it
  std::string_view name;  ///< the word in the scene file, and the name of its source file
  Origin origin = Origin::PbrtV2;
  std::string_view summary;
  std::vector<ParamRecord> (*describe)() = nullptr;  ///< its parameters with their defaults
};

/// All plugins of all kinds, sorted by kind and name.
std::vector<const PluginInfo*> allPlugins();
void addPluginInfo(const PluginInfo* info);

/// A created plugin and its effective parameters, for the metadata.
template <class Interface>
struct Created {
  std::unique_ptr<Interface> plugin;
  std::vector<ParamRecord> params;
};

/// The plugins of one interface. Interface declares `using FactoryContext` and `static constexpr
/// kPluginKind`.
template <class Interface>
class Registry {
 public:
  using Context = typename Interface::FactoryContext;
  struct Entry : PluginInfo {
    std::unique_ptr<Interface> (*create)(ParamReader&, const Context&,
                                         std::vector<ParamRecord>* effective) = nullptr;
    /// Reads the parameters as create does, with all its errors, and makes nothing.
    void (*check)(ParamReader&) = nullptr;
  };

  static std::vector<const Entry*>& entries() {
    static std::vector<const Entry*> all;
    return all;
  }
  static const Entry* find(std::string_view name) {
    for (const Entry* e : entries())
      if (e->name == name) return e;
    return nullptr;
  }
  static std::vector<std::string> names() {
    std::vector<std::string> result;
    for (const Entry* e : entries()) result.emplace_back(e->name);
    std::sort(result.begin(), result.end());
    return result;
  }
};

template <class Interface, class Plugin>
class RegisterPlugin {
 public:
  RegisterPlugin(std::string_view name, Origin origin, std::string_view summary) {
    using Context = typename Interface::FactoryContext;
    entry_.kind = Interface::kPluginKind;
    entry_.name = name;
    entry_.origin = origin;
    entry_.summary = summary;
    entry_.describe = [] {
      typename Plugin::Params params;
      ParamRecorder recorder;
      params.visit(recorder);
      return std::move(recorder.records);
    };
    entry_.create = [](ParamReader& reader, const Context& context,
                       std::vector<ParamRecord>* effective) -> std::unique_ptr<Interface> {
      typename Plugin::Params params;
      params.visit(reader);
      if (effective) {
        ParamRecorder recorder;
        params.visit(recorder);
        *effective = std::move(recorder.records);
      }
      return std::make_unique<Plugin>(std::move(params), context);
    };
    entry_.check = [](ParamReader& reader) {
      typename Plugin::Params params;
      params.visit(reader);
    };
    Registry<Interface>::entries().push_back(&entry_);
    addPluginInfo(&entry_);
  }

 private:
  typename Registry<Interface>::Entry entry_;
};

}  // namespace brume
