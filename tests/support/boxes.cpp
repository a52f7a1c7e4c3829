// SPDX-License-Identifier: Apache-2.0
#include "support/boxes.h"

#include <algorithm>
#include <cmath>

namespace brume::test {

std::string emittingBox() {
  return "AttributeBegin\nAreaLightSource \"area\" \"color L\" [.5 .5 .5]\n"
         "Material \"matte\" \"color Kd\" [.5 .5 .5]\nShape \"trianglemesh\" \"point P\" "
         "[-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1  -1 -1 1  1 -1 1  1 1 1  -1 1 1] "
         "\"integer indices\" [0 1 2 0 2 3  5 4 7 5 7 6  4 0 3 4 3 7  1 5 6 1 6 2  3 2 6 3 6 7  "
         "4 5 1 4 1 0]\nAttributeEnd\n";
}

double unevenDensity(double x, double y, double z) {
  const int n[3] = {3, 4, 3};
  const double p[3] = {x, y, z};
  int i0[3];
  double f[3];
  for (int a = 0; a < 3; ++a) {
    const double v = std::clamp(0.5 * (p[a] + 1) * n[a] - 0.5, 0.0, n[a] - 1.0);
    i0[a] = std::min(static_cast<int>(v), n[a] - 2);
    f[a] = v - i0[a];
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    int i[3];
    for (int a = 0; a < 3; ++a) {
      const int up = corner >> a & 1;
      weight *= up ? f[a] : 1 - f[a];
      i[a] = i0[a] + up;
    }
    sum += weight * kVoxels[static_cast<std::size_t>((i[2] * n[1] + i[1]) * n[0] + i[0])];
  }
  return sum;
}

}  // namespace brume::test
