// SPDX-License-Identifier: Apache-2.0
#include "core/film_layers.h"

namespace brume {

const std::array<std::string, kLayerChannels>& layerChannelNames() {
  static const auto names = [] {
    std::array<std::string, kLayerChannels> result;
    std::size_t next = 0;
    const auto add = [&](std::string_view layer, const char* channels) {
      for (const char* c = channels; *c; ++c) result[next++] = std::string(layer) + "." + *c;
    };
    for (int i = 0; i < kPathComponents; ++i)
      add(componentName(static_cast<PathComponent>(i)), "RGB");
    add("transmittance", "RGB");
    add("albedo", "RGB");
    add("normal", "XYZ");
    add("depth", "Z");
    return result;
  }();
  return names;
}

std::array<float, kLayerChannels> layerValues(const LayerSample& sample) {
  std::array<float, kLayerChannels> values{};
  std::size_t next = 0;
  const auto add = [&](const auto& v) {
    for (int c = 0; c < 3; ++c) values[next++] = v[c];
  };
  const ComponentRadiance components = sample.components.value_or(ComponentRadiance());
  for (int i = 0; i < kPathComponents; ++i) add(components[static_cast<PathComponent>(i)]);
  add(sample.transmittance);
  add(sample.albedo);
  add(sample.normal);
  values[next] = sample.depth;
  return values;
}

}  // namespace brume
