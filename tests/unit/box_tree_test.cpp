// SPDX-License-Identifier: Apache-2.0
#include "volumes/box_tree.h"

#include <gtest/gtest.h>

#include <set>

#include "core/rng.h"
#include "core/sampling.h"

namespace brume {
namespace {

using Set = std::set<std::uint32_t>;

std::vector<Bounds3> randomBoxes(Rng& rng, int count, float scale) {
  std::vector<Bounds3> boxes;
  for (int i = 0; i < count; ++i) {
    const Vec3 lo = scale * (Vec3(rng.uniform(), rng.uniform(), rng.uniform()) - Vec3(0.5f));
    const float size = scale * 0.3f * rng.uniform() * rng.uniform();
    // Flat ones, and equal ones.
    const Vec3 d = size * Vec3(rng.uniform(), i % 5 == 0 ? 0.f : rng.uniform(), rng.uniform());
    boxes.push_back(i % 7 == 6 ? boxes.back() : Bounds3{lo, lo + d});
  }
  return boxes;
}

/// In double: that the ray meets the box itself.
bool meets(const Bounds3& b, const Ray& ray, Interval range) {
  double t0 = double{range.t0}, t1 = double{range.t1};
  for (int a = 0; a < 3; ++a) {
    if (ray.d[a] == 0) {
      if (!(ray.o[a] >= b.lo[a] && ray.o[a] <= b.hi[a])) return false;
      continue;
    }
    const double toLo = (double{b.lo[a]} - double{ray.o[a]}) / double{ray.d[a]},
                 toHi = (double{b.hi[a]} - double{ray.o[a]}) / double{ray.d[a]};
    t0 = std::max(t0, std::min(toLo, toHi));
    t1 = std::min(t1, std::max(toLo, toHi));
  }
  return t0 <= t1;
}

TEST(BoxTree, NamesEveryBoxThatIsMetAndFewOthers) {
  Rng rng(1);
  std::size_t named = 0, met = 0, asked = 0;
  for (const float scale : {1e-6f, 1.f, 1e9f})
    for (const int count : {0, 1, 2, 3, 5, 200, 1000}) {
      const std::vector<Bounds3> boxes = randomBoxes(rng, count, scale);
      const BoxTree tree(boxes);
      for (int i = 0; i < 300; ++i) {
        Vec3 d = sampleUniformSphere(rng.uniform2());
        if (i % 4 == 0) d = {0, 0, rng.uniform() < 0.5f ? 1.f : -1.f};  // along faces
        Vec3 o = scale * (Vec3(rng.uniform(), rng.uniform(), rng.uniform()) - Vec3(0.5f));
        // From a corner, and along an edge.
        if (count > 0 && i % 3 == 0) o = boxes[rng.below(static_cast<std::uint32_t>(count))].lo;
        const Ray ray{o, d, kInfinity, 0};
        const Interval range{0, i % 2 == 0 ? kInfinity : scale * rng.uniform()};
        std::vector<std::uint32_t> along, at;
        tree.forEachAlong(ray, range, [&](std::uint32_t b) { along.push_back(b); });
        tree.forEachAt(o, [&](std::uint32_t b) { at.push_back(b); });
        const Set alongSet(along.begin(), along.end()), atSet(at.begin(), at.end());
        EXPECT_EQ(alongSet.size(), along.size());
        EXPECT_EQ(atSet.size(), at.size());
        for (std::uint32_t b = 0; b < boxes.size(); ++b) {
          if (meets(boxes[b], ray, range)) {
            EXPECT_TRUE(alongSet.contains(b));
            ++met;
          }
          if (boxes[b].contains(o)) {
            EXPECT_TRUE(atSet.contains(b));
          }
        }
        named += along.size();
        asked += boxes.size();
      }
    }
  // Leaves of two, and boxes that are just missed.
  EXPECT_LT(named, 3 * met);
  EXPECT_LT(named, asked / 8);
}

}  // namespace
}  // namespace brume
