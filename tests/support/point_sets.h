// SPDX-License-Identifier: Apache-2.0
// Point sets that search structures must survive.
#pragma once

#include <string>
#include <vector>

#include "core/rng.h"

namespace brume::test {

struct PointSet {
  std::string name;
  std::vector<Vec3> points;
  Vec3 middle{0};
  float size = 1;  ///< queries are drawn from a box of this half-width around the middle
};

inline Vec3 randomInBox(Rng& rng, const Vec3& middle, float size) {
  const Vec3 u(rng.uniform(), rng.uniform(), rng.uniform());
  return middle + (2.f * u - Vec3(1)) * size;
}

/// Random and degenerate sets of about n points.
inline std::vector<PointSet> pointSets(int n) {
  Rng rng(1);
  const auto fill = [&](auto&& make) {
    std::vector<Vec3> points;
    for (int i = 0; i < n; ++i) points.push_back(make());
    return points;
  };
  const auto box = [&](const Vec3& middle, float size) { return randomInBox(rng, middle, size); };
  std::vector<PointSet> sets;
  sets.push_back({"none", {}});
  sets.push_back({"one", {Vec3(0.5f, 0, 0)}});
  sets.push_back({"nine", {9, Vec3(0.25f)}});
  sets.push_back({"uniform", fill([&] { return box(Vec3(0), 1); })});
  sets.push_back({"all equal", fill([] { return Vec3(0.5f, -0.5f, 0.25f); })});
  sets.push_back({"collinear", fill([&] { return Vec3(1, 2, -1) * (rng.uniform() - 0.5f); })});
  sets.push_back({"one plane", fill([&] { return Vec3(1, 0, 1) * box(Vec3(0), 1); })});
  sets.push_back(
      {"lattice", fill([&] { return Vec3(Vec3(glm::ivec3(box(Vec3(0), 1) * 4.f))) * 0.25f; })});
  sets.push_back({"clusters", fill([&] {
                    const Vec3 middle(rng.below(2) != 0 ? 1.f : -1.f, 0, 0);
                    return middle + box(Vec3(0), std::pow(10.f, -4 * rng.uniform()));
                  })});
  sets.push_back({"small", fill([&] { return box(Vec3(0), 1e-6f); }), Vec3(0), 1e-6f});
  sets.push_back({"huge", fill([&] { return box(Vec3(0), 1e9f); }), Vec3(0), 1e9f});
  sets.push_back({"far off", fill([&] { return box(Vec3(1e5f), 1); }), Vec3(1e5f), 1});
  return sets;
}

}  // namespace brume::test
