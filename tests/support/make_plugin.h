// SPDX-License-Identifier: Apache-2.0
// Plugins from parameters given in code, as the scene language would make them.
#pragma once

#include <string>
#include <vector>

#include "core/log.h"
#include "core/registry.h"

namespace brume::test {

inline Param floats(std::string name, std::vector<float> v) {
  return {ParamType::Float, std::move(name), {}, std::move(v)};
}
inline Param integers(std::string name, std::vector<int> v) {
  return {ParamType::Integer, std::move(name), {}, std::move(v)};
}
inline Param boolean(std::string name, bool v) {
  return {ParamType::Bool, std::move(name), {}, std::vector<bool>{v}};
}
inline Param string(std::string name, std::string v) {
  return {ParamType::String, std::move(name), {}, std::vector<std::string>{std::move(v)}};
}
inline Param texture(std::string name, std::string v) {
  return {ParamType::Texture, std::move(name), {}, std::vector<std::string>{std::move(v)}};
}
inline Param color(std::string name, Rgb v) {
  return {ParamType::Color, std::move(name), {}, std::vector<Rgb>{v}};
}
inline Param points(std::string name, std::vector<Vec3> v) {
  return {ParamType::Point, std::move(name), {}, std::move(v)};
}
inline Param vectors(std::string name, std::vector<Vec3> v) {
  return {ParamType::Vector, std::move(name), {}, std::move(v)};
}
inline Param normals(std::string name, std::vector<Vec3> v) {
  return {ParamType::Normal, std::move(name), {}, std::move(v)};
}

inline ParamSet paramSet(std::vector<Param> params) {
  ParamSet set;
  for (Param& p : params) set.add(std::move(p));
  return set;
}

/// A log that keeps its lines.
inline Log& captureLog() {
  static Log log(Log::Options{Verbosity::Verbose, false, true});
  return log;
}

/// The plugin `name` of the interface, from parameters; throws as the scene language would. Null
/// when no such plugin exists.
template <class Interface>
std::unique_ptr<Interface> make(std::string_view name, std::vector<Param> params,
                                typename Interface::FactoryContext context = {},
                                TextureLookup* textures = nullptr, Log& log = captureLog()) {
  const auto* entry = Registry<Interface>::find(name);
  if (!entry) return nullptr;
  ParamSet set = paramSet(std::move(params));
  ParamReader reader({&set}, std::string(name), ".", textures, log);
  context.log = &log;
  auto plugin = entry->create(reader, context, nullptr);
  reportUnusedParams(set, name, entry->origin, reader.declared(), log);
  return plugin;
}

}  // namespace brume::test
