// SPDX-License-Identifier: Apache-2.0
#include "core/path_component.h"

namespace brume {

std::string_view componentName(PathComponent component) {
  static constexpr std::array<std::string_view, kPathComponents> kNames = {
      "emission",      "surface_direct", "surface_caustic", "surface_indirect",
      "volume_single", "volume_caustic", "volume_multiple"};
  return kNames[static_cast<std::size_t>(component)];
}

}  // namespace brume
