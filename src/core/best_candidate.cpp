// SPDX-License-Identifier: Apache-2.0
#include "core/best_candidate.h"

#include "core/lowdiscrepancy.h"

namespace brume {

namespace {

constexpr int kGrid = BestCandidatePattern::kGrid;

float torusDistance(float a, float b) {
  const float d = std::abs(a - b);
  return std::min(d, 1.f - d);
}
float torusDistanceSquared(Vec2 a, Vec2 b) {
  return sqr(torusDistance(a.x, b.x)) + sqr(torusDistance(a.y, b.y));
}

/// Points thrown so far, in lists per cell of a grid on the torus.
class PointGrid {
 public:
  PointGrid() : first_(BestCandidatePattern::kCount, -1) {}

  void add(Vec2 p) {
    int& head = first_[cellOf(p)];
    next_.push_back(head);
    points_.push_back(p);
    head = static_cast<int>(points_.size()) - 1;
  }
  /// Squared distance to the nearest point; the search goes ring by ring around the cell of p and
  /// gives up where the result cannot exceed `enough` any more.
  float nearestSquared(Vec2 p, float enough) const {
    const int cx = static_cast<int>(p.x * kGrid), cy = static_cast<int>(p.y * kGrid);
    float best = kInfinity;
    for (int ring = 0; ring <= kGrid / 2; ++ring) {
      // Whatever lies in this ring is at least ring - 1 cells away.
      const float reach = static_cast<float>(std::max(0, ring - 1)) / kGrid;
      if (best <= sqr(reach) || best <= enough) break;
      for (int dy = -ring; dy <= ring; ++dy) {
        const int step = std::abs(dy) == ring || ring == 0 ? 1 : 2 * ring;
        for (int dx = -ring; dx <= ring; dx += step)
          best = std::min(best, inCell(cx + dx, cy + dy, p));
      }
    }
    return best;
  }

 private:
  static std::size_t cellOf(Vec2 p) {
    return static_cast<std::size_t>(p.y * kGrid) * kGrid + static_cast<std::size_t>(p.x * kGrid);
  }
  float inCell(int x, int y, Vec2 p) const {
    const int wrapped = (y & (kGrid - 1)) * kGrid + (x & (kGrid - 1));
    float best = kInfinity;
    for (int i = first_[static_cast<std::size_t>(wrapped)]; i >= 0;
         i = next_[static_cast<std::size_t>(i)])
      best = std::min(best, torusDistanceSquared(p, points_[static_cast<std::size_t>(i)]));
    return best;
  }

  std::vector<int> first_, next_;
  std::vector<Vec2> points_;
};

}  // namespace

BestCandidatePattern::BestCandidatePattern() {
  constexpr int kCandidates = 24;
  Rng rng(hashIntegers(0x62657374, kCount));
  PointGrid grid;
  points_.reserve(kCount);
  // Each point is the candidate that lies farthest from all earlier ones.
  for (int i = 0; i < kCount; ++i) {
    Vec2 best = rng.uniform2();
    if (i > 0) {
      float bestDistance = grid.nearestSquared(best, 0);
      for (int c = 1; c < kCandidates; ++c) {
        const Vec2 p = rng.uniform2();
        const float d = grid.nearestSquared(p, bestDistance);
        if (d > bestDistance) bestDistance = d, best = p;
      }
    }
    grid.add(best);
    points_.push_back({best, Vec2(0), 0});
  }
  sortByCell();
  assignTimesAndLenses();
}

void BestCandidatePattern::sortByCell() {
  const auto cellOf = [](const Point& p) {
    return static_cast<std::size_t>(p.position.y * kGrid) * kGrid +
           static_cast<std::size_t>(p.position.x * kGrid);
  };
  // Counting sort, so that the order does not depend on the library.
  cellStart_.fill(0);
  for (const Point& p : points_) ++cellStart_[cellOf(p) + 1];
  for (std::size_t c = 1; c < cellStart_.size(); ++c) cellStart_[c] += cellStart_[c - 1];
  std::vector<Point> sorted(points_.size());
  std::array<std::uint32_t, kCount + 1> next = cellStart_;
  for (const Point& p : points_) sorted[next[cellOf(p)]++] = p;
  points_ = std::move(sorted);
}

void BestCandidatePattern::assignTimesAndLenses() {
  // The values to hand out are a (0,2)-net and a set of equal steps: their marginals are exact.
  std::vector<Vec2> lenses(kCount);
  std::vector<float> times(kCount);
  for (std::uint32_t i = 0; i < kCount; ++i) {
    lenses[i] = {uniformFloat(reverseBits(i)), uniformFloat(reverseBits(sobolSecondReversed(i)))};
    times[i] = (static_cast<float>(i) + 0.5f) / kCount;
  }

  // Points are visited in random order; each takes, among a few values that are left, the one most
  // unlike those of the neighbours that have theirs.
  constexpr std::size_t kCandidates = 12;
  constexpr float kNeighbourhood = 1.5f / kGrid;
  Rng rng(hashIntegers(0x6c656e73, kCount));
  std::vector<bool> done(kCount, false);
  std::vector<const Point*> neighbours;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const std::size_t at = permutedIndex(i, kCount, 0x9e3779b9u);
    Point& point = points_[at];
    neighbours.clear();
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const auto wrap = [](float x) { return x - std::floor(x); };
        const Vec2 p(wrap(point.position.x + static_cast<float>(dx) / kGrid),
                     wrap(point.position.y + static_cast<float>(dy) / kGrid));
        forEachNear(p, p, [&](const Point& other) {
          if (done[static_cast<std::size_t>(&other - points_.data())] &&
              torusDistanceSquared(other.position, point.position) < sqr(kNeighbourhood))
            neighbours.push_back(&other);
        });
      }
    const auto take = [&](auto& values, const auto& distance) {
      std::size_t best = 0;
      float bestDistance = -1;
      for (std::size_t c = 0; c < kCandidates; ++c) {
        const std::size_t candidate = rng.below(static_cast<std::uint32_t>(values.size()));
        float d = kInfinity;
        for (const Point* other : neighbours) d = std::min(d, distance(values[candidate], *other));
        if (d > bestDistance) bestDistance = d, best = candidate;
      }
      const auto value = values[best];
      values[best] = values.back();
      values.pop_back();
      return value;
    };
    point.lens = take(
        lenses, [](Vec2 v, const Point& other) { return torusDistanceSquared(v, other.lens); });
    point.time =
        take(times, [](float v, const Point& other) { return torusDistance(v, other.time); });
    done[at] = true;
  }
}

}  // namespace brume
