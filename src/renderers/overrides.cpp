// SPDX-License-Identifier: Apache-2.0
#include "renderers/overrides.h"

#include <fmt/format.h>

#include <charconv>

#include "core/integrator.h"
#include "core/log.h"
#include "core/registry.h"

namespace brume {
namespace {

/// PBRT-v2's plugins that brume does not build, and what to write in their place.
struct Unbuilt {
  std::string_view name, instead;
};
constexpr std::string_view kUsePath =
    "use SurfaceIntegrator \"path\" (or --integrator path), which computes the same light";
constexpr Unbuilt kUnbuiltIntegrators[] = {
    {"igi", kUsePath},
    {"irradiancecache", kUsePath},
    {"dipolesubsurface",
     "use SurfaceIntegrator \"path\" (or --integrator path), which shows "
     "subsurface materials as specular reflectors"},
    {"diffuseprt", kUsePath},
    {"glossyprt", kUsePath},
    {"useprobes", kUsePath}};
constexpr Unbuilt kUnbuiltRenderers[] = {
    {"metropolis",
     "use Renderer \"sampler\" with SurfaceIntegrator \"path\" (or --integrator path)"},
    {"createprobes", "it makes no image; remove the directive to render one"},
    {"surfacepoints", "it makes no image; remove the directive to render one"},
    {"aggregatetest", "it makes no image; remove the directive to render one"}};

template <std::size_t N>
const Unbuilt* findUnbuilt(const Unbuilt (&list)[N], std::string_view name) {
  for (const Unbuilt& u : list)
    if (u.name == name) return &u;
  return nullptr;
}

[[noreturn]] void failUnbuilt(const SourceLocation& where, std::string_view kind,
                              const Unbuilt& unbuilt) {
  throw SceneError(where, fmt::format("{} \"{}\" is not part of brume; {}", kind, unbuilt.name,
                                      unbuilt.instead));
}

/// The integrator of that name, of whichever kind.
const PluginInfo* findIntegrator(std::string_view name) {
  if (const auto* e = Registry<SurfaceIntegrator>::find(name)) return e;
  if (const auto* e = Registry<VolumeIntegrator>::find(name)) return e;
  return Registry<GlobalIntegrator>::find(name);
}

std::vector<std::string> integratorNames() {
  std::vector<std::string> all = Registry<SurfaceIntegrator>::names();
  for (const auto& more :
       {Registry<VolumeIntegrator>::names(), Registry<GlobalIntegrator>::names()})
    all.insert(all.end(), more.begin(), more.end());
  return all;
}

template <class T>
std::vector<T> parseNumbers(const std::string& key, std::string_view type, std::string_view text) {
  std::vector<T> values;
  const char* end = text.data() + text.size();
  for (const char* at = text.data(); at != end;) {
    if (*at == ' ') {
      ++at;
      continue;
    }
    T value{};
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || (next != end && *next != ' '))
      throw SceneError(
          fmt::format("--integrator: '{}' for \"{} {}\" is not a number", text, type, key));
    values.push_back(value);
    at = next;
  }
  return values;
}

/// A value of the command line as the scene language would hold it.
Param makeParam(const ParamRecord& record, const std::string& key, const std::string& text) {
  Param param;
  param.name = key;
  const std::string& type = record.type;
  const auto is = [&](ParamType t) { return type == toString(t); };
  if (is(ParamType::Integer)) {
    param.type = ParamType::Integer;
    param.values = parseNumbers<int>(key, type, text);
  } else if (is(ParamType::Float)) {
    param.type = ParamType::Float;
    param.values = parseNumbers<float>(key, type, text);
  } else if (is(ParamType::Bool)) {
    if (text != "true" && text != "false")
      throw SceneError(
          fmt::format("--integrator: \"bool {}\" is 'true' or 'false', not '{}'", key, text));
    param.type = ParamType::Bool;
    param.values = std::vector<bool>{text == "true"};
  } else if (is(ParamType::String)) {
    param.type = ParamType::String;
    param.values = std::vector<std::string>{text};
  } else {
    throw SceneError(
        fmt::format("--integrator: \"{} {}\" can be given in the scene only", type, key));
  }
  return param;
}

void addParam(const PluginInfo& info, std::string_view assignment, ParamSet& params) {
  const std::size_t equals = assignment.find('=');
  const std::string key(assignment.substr(0, equals));
  std::vector<std::string> known;
  for (const ParamRecord& record : info.describe()) {
    known.push_back(record.name);
    if (record.name != key) continue;
    if (equals == std::string_view::npos)
      throw SceneError(fmt::format("--integrator: '{}' has no value; write {}=VALUE", key, key));
    params.add(makeParam(record, key, std::string(assignment.substr(equals + 1))));
    return;
  }
  if (known.empty())
    throw SceneError(fmt::format("--integrator: '{}' has no parameters", info.name));
  throw SceneError(fmt::format("--integrator: '{}' has no parameter '{}'{}; choose {}", info.name,
                               key, nearestSpelling(key, known), listChoices(known)));
}

}  // namespace

PluginDirective parseIntegrator(const std::string& argument) {
  const std::size_t colon = argument.find(':');
  PluginDirective directive;
  directive.name = argument.substr(0, colon);
  const PluginInfo* info = findIntegrator(directive.name);
  if (!info) {
    if (const Unbuilt* u = findUnbuilt(kUnbuiltIntegrators, directive.name))
      failUnbuilt({}, "SurfaceIntegrator", *u);
    const std::vector<std::string> names = integratorNames();
    throw SceneError(fmt::format("--integrator: there is no integrator '{}'{}; choose {}",
                                 directive.name, nearestSpelling(directive.name, names),
                                 listChoices(names)));
  }
  if (colon == std::string::npos) return directive;
  std::string_view rest = std::string_view(argument).substr(colon + 1);
  while (!rest.empty()) {
    const std::size_t comma = rest.find(',');
    addParam(*info, rest.substr(0, comma), directive.params);
    rest = comma == std::string_view::npos ? std::string_view{} : rest.substr(comma + 1);
  }
  return directive;
}

void overrideIntegrators(const std::vector<std::string>& arguments, RenderOptions& options,
                         Log& log) {
  if (arguments.empty()) return;
  options.globalIntegrator.reset();
  for (const std::string& argument : arguments) {
    PluginDirective directive = parseIntegrator(argument);
    const std::string_view kind = findIntegrator(directive.name)->kind;
    log.verbose(fmt::format("--integrator: {} \"{}\" replaces the scene's", kind, directive.name));
    if (kind == SurfaceIntegrator::kPluginKind)
      options.surfaceIntegrator = std::move(directive);
    else if (kind == VolumeIntegrator::kPluginKind)
      options.volumeIntegrator = std::move(directive);
    else
      options.globalIntegrator = std::move(directive);
  }
}

void refuseUnbuilt(RenderOptions& options, bool integratorGiven, Log& log) {
  const PluginDirective& renderer = options.renderer;
  if (const Unbuilt* u = findUnbuilt(kUnbuiltRenderers, renderer.name)) {
    if (!integratorGiven) failUnbuilt(renderer.params.where(), "Renderer", *u);
    log.warning(renderer.params.where(),
                fmt::format("Renderer \"{}\" is not part of brume; the integrator that the command "
                            "line names renders instead",
                            renderer.name));
    options.renderer = {"sampler", ParamSet(renderer.params.where())};
  }
  if (options.globalIntegrator) return;
  const PluginDirective& surface = options.surfaceIntegrator;
  if (const Unbuilt* u = findUnbuilt(kUnbuiltIntegrators, surface.name))
    if (!Registry<SurfaceIntegrator>::find(surface.name))
      failUnbuilt(surface.params.where(), "SurfaceIntegrator", *u);
}

}  // namespace brume
