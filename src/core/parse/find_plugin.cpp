// SPDX-License-Identifier: Apache-2.0
#include "core/parse/find_plugin.h"

#include <fmt/format.h>

#include "core/io/source_file.h"

namespace brume {

namespace {

/// Parts of PBRT-v2's world block that brume does not have.
struct Absent {
  std::string_view kind, name, instead;
};
constexpr Absent kAbsent[] = {
    {"Material", "subsurface", "use \"translucent\", or \"glass\" around a Volume"},
    {"Material", "kdsubsurface", "use \"translucent\", or \"glass\" around a Volume"},
    {"Texture float", "uv", "it yields colors: define it as \"color\""},
    {"Texture float", "marble", "it yields colors: define it as \"color\""}};

/// PBRT-v2's second names.
struct Alias {
  std::string_view kind, name, registered;
};
constexpr Alias kAliases[] = {{"AreaLightSource", "area", "diffuse"},
                              {"LightSource", "exinfinite", "infinite"}};

}  // namespace

std::string_view registeredName(std::string_view kind, std::string_view name) {
  for (const Alias& alias : kAliases)
    if (alias.kind == kind && alias.name == name) return alias.registered;
  return name;
}

std::string unknownPlugin(std::string_view kind, std::string_view name,
                          const std::vector<std::string>& choices) {
  for (const Absent& absent : kAbsent)
    if (absent.kind == kind && absent.name == name)
      return fmt::format("{} \"{}\" is not part of brume; {}", kind, name, absent.instead);
  return fmt::format("unknown {} {}{}; choose {}", kind, quote(name, '"'),
                     nearestSpelling(name, choices), listChoices(choices));
}

}  // namespace brume
