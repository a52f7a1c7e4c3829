// SPDX-License-Identifier: Apache-2.0
// A mesh of any size for measurements.
#pragma once

#include <string>
#include <vector>

#include "core/math.h"

namespace brume::bench {

/// A square of 2 (side - 1)^2 triangles over [0, 1]^2 with small waves in z.
struct WavyGrid {
  std::vector<Vec3> points;
  std::vector<int> indices;
};
WavyGrid wavyGrid(int side);

/// A scene file of about that many bytes that holds one such mesh.
std::string wavyGridScene(std::size_t bytes);

}  // namespace brume::bench
