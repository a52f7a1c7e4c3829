// SPDX-License-Identifier: Apache-2.0
#include "accelerators/kd_order.h"

#include "accelerators/photon_kdtree.h"

namespace brume {
namespace {

/// A point on its way to its place.
struct Item {
  Vec3 p{0};
  std::uint32_t index = 0;
};

/// Items [begin, end) that become children of one node; all but the last hold `child` items.
struct Range {
  std::size_t begin = 0, end = 0;
  std::size_t child = kLanes;
  std::size_t size() const { return end - begin; }
};

/// Ranges up to this size are one task; the larger ones are split level by level.
constexpr std::size_t kTask = 1 << 14;
/// Below, each item is compared with each.
constexpr std::size_t kFewItems = 64;
/// Below, clearing and adding up many bins costs more than it saves.
constexpr std::size_t kManyItems = 2048;

/// The items of one range, and room for as many.
struct Work {
  Item* items;
  Item* room;
  std::size_t size;
};

/// Which axis a range is split across, and how its coordinates are cut into bins.
struct Axis {
  int axis = 0;
  float lo = 0;
  float extent = 0;
};

Axis widestAxis(const Item* items, std::size_t size) {
  Vec3 lo(kInfinity), hi(-kInfinity);
  for (std::size_t i = 0; i < size; ++i) {
    lo = min(lo, items[i].p);
    hi = max(hi, items[i].p);
  }
  const Vec3 extent = hi - lo;
  const int axis =
      extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
  return {axis, lo[axis], extent[axis]};
}

/// Moves the `left` items that are lowest on the axis to the front.
void select(Item* items, std::size_t size, std::size_t left, int axis) {
  std::nth_element(items, items + left, items + size, [axis](const Item& a, const Item& b) {
    return a.p[axis] < b.p[axis] || (a.p[axis] == b.p[axis] && a.index < b.index);
  });
}

/// The same for few items: each goes to the place that counting finds, without a branch.
void selectByCounting(const Work& work, int axis) {
  std::array<float, kFewItems> keys{};
  for (std::size_t i = 0; i < work.size; ++i) keys[i] = work.items[i].p[axis];
  for (std::size_t i = 0; i < work.size; ++i) {
    std::int32_t before = 0;
    for (std::size_t j = 0; j < i; ++j) before += keys[j] <= keys[i] ? 1 : 0;
    for (std::size_t j = i + 1; j < work.size; ++j) before += keys[j] < keys[i] ? 1 : 0;
    work.room[before] = work.items[i];
  }
  std::copy_n(work.room, work.size, work.items);
}

/// The same by a histogram: only the items of the bin with the median are compared.
template <std::size_t kBins>
void selectByHistogram(const Work& work, std::size_t left, const Axis& along) {
  const float scale = static_cast<float>(kBins) / along.extent;
  if (!std::isfinite(scale) || !std::isfinite(along.extent))
    return select(work.items, work.size, left, along.axis);
  const auto binOf = [&](const Item& item) {
    const auto bin = static_cast<std::int32_t>((item.p[along.axis] - along.lo) * scale);
    return std::min(bin, static_cast<std::int32_t>(kBins) - 1);
  };
  std::array<std::uint32_t, kBins> counts{};
  for (std::size_t i = 0; i < work.size; ++i)
    ++counts[static_cast<std::size_t>(binOf(work.items[i]))];
  std::size_t median = 0, below = 0;
  while (below + counts[median] < left) below += counts[median++];

  // Below, in and above the bin with the median.
  std::array<Item*, 3> to{work.room, work.room + below, work.room + below + counts[median]};
  const auto medianBin = static_cast<std::int32_t>(median);
  for (std::size_t i = 0; i < work.size; ++i) {
    const std::int32_t bin = binOf(work.items[i]);
    *to[std::size_t{bin >= medianBin} + std::size_t{bin > medianBin}]++ = work.items[i];
  }
  std::copy_n(work.room, work.size, work.items);
  const Work rest{work.items + below, work.room + below, counts[median]};
  if (rest.size <= kFewItems)
    selectByCounting(rest, along.axis);
  else
    select(rest.items, rest.size, left - below, along.axis);
}

/// Splits a range in two, or finds it done (none).
std::optional<std::size_t> split(Item* items, Item* room, Range& range) {
  while (range.size() <= range.child) {
    if (range.child == kLanes) return std::nullopt;
    range.child /= kLanes;
  }
  const std::size_t children = (range.size() + range.child - 1) / range.child;
  const std::size_t left = (children + 1) / 2 * range.child;
  const Work work{items + range.begin, room + range.begin, range.size()};
  const Axis along = widestAxis(work.items, work.size);
  if (!(along.extent > 0)) return range.begin + left;
  if (work.size <= kFewItems)
    selectByCounting(work, along.axis);
  else if (work.size < kManyItems)
    selectByHistogram<32>(work, left, along);
  else
    selectByHistogram<256>(work, left, along);
  return range.begin + left;
}

void splitAll(Item* items, Item* room, Range range) {
  while (const auto at = split(items, room, range)) {
    splitAll(items, room, {range.begin, *at, range.child});
    range.begin = *at;
  }
}

/// Splits what is too large for one task, all ranges of one depth at a time.
std::vector<Range> tasks(Item* items, Item* room, Range all) {
  std::vector<Range> done, open{all};
  while (!open.empty()) {
    std::vector<std::size_t> at(open.size());
    forEachChunk(static_cast<std::int64_t>(open.size()), 1,
                 [&](std::int64_t begin, std::int64_t, std::int64_t) {
                   const auto i = static_cast<std::size_t>(begin);
                   if (open[i].size() > kTask) at[i] = split(items, room, open[i]).value_or(0);
                 });
    std::vector<Range> next;
    for (std::size_t i = 0; i < open.size(); ++i) {
      if (at[i] == 0) {
        done.push_back(open[i]);
        continue;
      }
      next.push_back({open[i].begin, at[i], open[i].child});
      next.push_back({at[i], open[i].end, open[i].child});
    }
    open = std::move(next);
  }
  return done;
}

}  // namespace

std::vector<std::uint32_t> kdOrder(const StridedPoints& points) {
  std::vector<Item> items(points.size()), room(points.size());
  for (std::size_t i = 0; i < items.size(); ++i)
    items[i] = {points[i], static_cast<std::uint32_t>(i)};
  Range all{0, items.size(), kLanes};
  while (all.child < all.end) all.child *= kLanes;
  const std::vector<Range> ranges = tasks(items.data(), room.data(), all);
  forEachChunk(static_cast<std::int64_t>(ranges.size()), 1,
               [&](std::int64_t begin, std::int64_t, std::int64_t) {
                 splitAll(items.data(), room.data(), ranges[static_cast<std::size_t>(begin)]);
               });
  std::vector<std::uint32_t> order(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) order[i] = items[i].index;
  return order;
}

}  // namespace brume
