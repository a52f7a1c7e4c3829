// SPDX-License-Identifier: Apache-2.0
// Sorting into few buckets, in parallel.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/parallel.h"

namespace brume {

/// A stable counting sort of fewer than 2^32 items that stand in groups. visit(group, f) calls f
/// with each item of a group, in order, and does so twice; bucketOf(item) is below `buckets`.
/// put(item, place) gets the place of each, counted from 0; groups run at the same time. Returns
/// where each bucket begins, and the number of items. The result does not depend on the groups;
/// they take groups * buckets counters. Test: counting_sort_test.
template <class Visit, class BucketOf, class Put>
std::vector<std::uint32_t> countingSort(std::size_t groups, std::size_t buckets, const Visit& visit,
                                        const BucketOf& bucketOf, const Put& put) {
  const auto forEachGroup = [&](const auto& body) {
    forEachChunk(static_cast<std::int64_t>(groups), 1,
                 [&](std::int64_t group, std::int64_t, std::int64_t) {
                   body(static_cast<std::size_t>(group));
                 });
  };
  std::vector<std::uint32_t> next(groups * buckets, 0);
  forEachGroup([&](std::size_t group) {
    std::uint32_t* const counts = next.data() + group * buckets;
    visit(group, [&](const auto& item) { ++counts[bucketOf(item)]; });
  });
  std::vector<std::uint32_t> begin(buckets + 1);
  std::uint32_t sum = 0;
  for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
    begin[bucket] = sum;
    for (std::size_t i = bucket; i < next.size(); i += buckets) sum += std::exchange(next[i], sum);
  }
  begin[buckets] = sum;
  forEachGroup([&](std::size_t group) {
    std::uint32_t* const places = next.data() + group * buckets;
    visit(group, [&](const auto& item) { put(item, places[bucketOf(item)]++); });
  });
  return begin;
}

/// Groups for countingSort: enough to go round, few enough that counting does not take longer than
/// sorting. At least 1, at most `most`.
inline std::size_t sortGroups(std::size_t items, std::size_t buckets, std::size_t most) {
  const std::size_t perGroup = std::max<std::size_t>(1 << 13, 8 * buckets);
  return std::clamp<std::size_t>(items / perGroup, 1, std::max<std::size_t>(1, most));
}

/// The part of `count` things that group `group` of `groups` takes: [first, second).
inline std::pair<std::size_t, std::size_t> groupRange(std::size_t group, std::size_t groups,
                                                      std::size_t count) {
  return {group * count / groups, (group + 1) * count / groups};
}

}  // namespace brume
