// SPDX-License-Identifier: Apache-2.0
#include "core/path_component.h"

#include <gtest/gtest.h>

#include <regex>
#include <string>

namespace brume {
namespace {

/// The component of a path written from the camera's first vertex to the last before the light, by
/// the regular expressions of DESIGN.md 6.
PathComponent expected(const std::string& vertices) {
  using enum PathComponent;
  const auto is = [&](const char* pattern) {
    return std::regex_match(vertices, std::regex(pattern));
  };
  if (is("S*")) return Emission;
  if (is("S*D")) return SurfaceDirect;
  if (is("S*DS+")) return SurfaceCaustic;
  if (is("S*D[SDV]*[DV][SDV]*")) return SurfaceIndirect;
  if (is("S*V")) return VolumeSingle;
  if (is("S*VS+")) return VolumeCaustic;
  return VolumeMultiple;
}

Scattering scattering(char vertex) {
  return vertex == 'S'   ? Scattering::Specular
         : vertex == 'D' ? Scattering::Surface
                         : Scattering::Medium;
}

TEST(PathComponent, AllPathsUpToFiveVerticesFromBothEnds) {
  int paths = 0;
  for (std::size_t length = 0; length <= 5; ++length) {
    int count = 1;
    for (std::size_t i = 0; i < length; ++i) count *= 3;
    for (int code = 0; code < count; ++code, ++paths) {
      std::string path;
      for (int rest = code; path.size() < length; rest /= 3) path += "SDV"[rest % 3];

      PathComponent component = PathComponent::Emission;
      for (char vertex : path) component = after(component, scattering(vertex));
      EXPECT_EQ(component, expected(path)) << path;

      // From the light up to the vertex where it is gathered, the first that is not specular.
      const std::size_t gather = path.find_first_not_of('S');
      if (gather == std::string::npos) continue;
      PathComponent fromLight = PathComponent::SurfaceDirect;
      for (std::size_t i = length; i-- > gather + 1;)
        fromLight = after(fromLight, scattering(path[i]));
      if (path[gather] == 'V') fromLight = inMedium(fromLight);
      EXPECT_EQ(fromLight, component) << path;
    }
  }
  EXPECT_EQ(paths, 364);
}

TEST(PathComponent, ComponentsAddUp) {
  ComponentRadiance radiance;
  for (int i = 0; i < kPathComponents; ++i)
    radiance.add(static_cast<PathComponent>(i), Rgb(1, float(i), 0));
  EXPECT_EQ(radiance.total(), Rgb(7, 21, 0));
  EXPECT_EQ(radiance[PathComponent::VolumeSingle], Rgb(1, 4, 0));
}

}  // namespace
}  // namespace brume
