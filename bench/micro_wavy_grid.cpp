// SPDX-License-Identifier: Apache-2.0
#include "micro_wavy_grid.h"

#include <fmt/format.h>

namespace brume::bench {

WavyGrid wavyGrid(int side) {
  WavyGrid grid;
  const auto n = static_cast<std::size_t>(side);
  grid.points.reserve(n * n);
  grid.indices.reserve(6 * n * n);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const Vec2 p = Vec2(x, y) / static_cast<float>(side - 1);
      grid.points.emplace_back(p.x, p.y, 0.02f * std::sin(40 * p.x) * std::cos(31 * p.y));
      if (x == 0 || y == 0) continue;
      const int at = y * side + x;
      for (const int i : {at - side - 1, at - side, at, at - side - 1, at, at - 1})
        grid.indices.push_back(i);
    }
  return grid;
}

std::string wavyGridScene(std::size_t bytes) {
  constexpr double kBytesPerPoint = 75;  // its coordinates and the indices of two triangles
  const WavyGrid grid =
      wavyGrid(static_cast<int>(std::sqrt(static_cast<double>(bytes) / kBytesPerPoint)));
  std::string text = "WorldBegin\nShape \"trianglemesh\" \"point P\" [\n";
  const auto out = std::back_inserter(text);
  text.reserve(bytes + bytes / 8);
  for (const Vec3& p : grid.points) fmt::format_to(out, "{:.6g} {:.6g} {:.6g}\n", p.x, p.y, p.z);
  text += "] \"integer indices\" [\n";
  for (std::size_t i = 0; i < grid.indices.size(); i += 3)
    fmt::format_to(out, "{} {} {}\n", grid.indices[i], grid.indices[i + 1], grid.indices[i + 2]);
  text += "]\nWorldEnd\n";
  return text;
}

}  // namespace brume::bench
