// SPDX-License-Identifier: Apache-2.0
#include "core/counting_sort.h"

#include <gtest/gtest.h>

#include "core/rng.h"

namespace brume {
namespace {

struct Item {
  std::uint32_t key, number;
  bool operator==(const Item&) const = default;
};

std::vector<Item> randomItems(std::size_t count, std::uint32_t buckets) {
  Rng rng(3);
  std::vector<Item> items;
  for (std::size_t i = 0; i < count; ++i)
    items.push_back({rng.below(buckets), static_cast<std::uint32_t>(i)});
  return items;
}

TEST(CountingSort, IsThatOfTheStandardLibraryForAnyGroups) {
  for (const std::size_t count : {0u, 1u, 7u, 5000u})
    for (const std::uint32_t buckets : {1u, 3u, 1024u}) {
      const std::vector<Item> items = randomItems(count, buckets);
      std::vector<Item> expected = items;
      std::stable_sort(expected.begin(), expected.end(),
                       [](const Item& a, const Item& b) { return a.key < b.key; });
      for (const std::size_t groups : {1u, 2u, 13u}) {
        std::vector<Item> sorted(count);
        const auto begin = countingSort(
            groups, buckets,
            [&](std::size_t group, const auto& f) {
              const auto [first, end] = groupRange(group, groups, count);
              for (std::size_t i = first; i < end; ++i) f(items[i]);
            },
            [](const Item& item) { return item.key; },
            [&](const Item& item, std::uint32_t at) { sorted.at(at) = item; });
        EXPECT_EQ(sorted, expected) << count << " " << buckets << " " << groups;
        ASSERT_EQ(begin.size(), buckets + 1);
        EXPECT_EQ(begin.back(), count);
        for (std::uint32_t b = 0; b < buckets; ++b)
          for (std::uint32_t i = begin[b]; i < begin[b + 1]; ++i) EXPECT_EQ(sorted[i].key, b);
      }
    }
}

TEST(CountingSort, GroupsCoverAllThings) {
  for (const std::size_t count : {0u, 1u, 5u, 1000u})
    for (const std::size_t groups : {1u, 3u, 7u}) {
      std::size_t next = 0;
      for (std::size_t g = 0; g < groups; ++g) {
        const auto [first, end] = groupRange(g, groups, count);
        EXPECT_EQ(first, next);
        next = end;
      }
      EXPECT_EQ(next, count);
    }
}

TEST(CountingSort, HasFewGroupsWhereBucketsAreMany) {
  EXPECT_EQ(sortGroups(0, 1024, 0), 1u);
  EXPECT_EQ(sortGroups(1000, 4, 100), 1u);
  EXPECT_EQ(sortGroups(1 << 20, 4, 1000), 128u);
  EXPECT_EQ(sortGroups(1 << 20, 1 << 16, 1000), 2u);
  EXPECT_EQ(sortGroups(1 << 20, 4, 5), 5u);
}

}  // namespace
}  // namespace brume
