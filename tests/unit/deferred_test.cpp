// SPDX-License-Identifier: Apache-2.0
#include "core/deferred.h"

#include <gtest/gtest.h>

#include <thread>

#include "core/error.h"
#include "core/file_cache.h"

namespace brume {
namespace {

TEST(Deferred, IsMadeByTheFirstWhoAsks) {
  int made = 0;
  const Deferred<int> number("file", 4, [&] { return ++made; });
  EXPECT_FALSE(number.isLoaded());
  EXPECT_EQ(made, 0);
  EXPECT_EQ(number.get(), 1);
  EXPECT_EQ(number.get(), 1);
  EXPECT_TRUE(number.isLoaded());
  EXPECT_EQ(&number.get(), &number.get());
}

/// Calls get() from eight threads at once.
template <class T, class Use>
void fromManyThreads(const Deferred<T>& deferred, const Use& use) {
  std::atomic<int> waiting{0};
  std::vector<std::jthread> threads;
  for (int i = 0; i < 8; ++i)
    threads.emplace_back([&] {
      ++waiting;
      while (waiting < 8) std::this_thread::yield();
      use(deferred);
    });
}

TEST(Deferred, IsMadeOnceForManyThreads) {
  for (int round = 0; round < 50; ++round) {
    std::atomic<int> made{0}, right{0};
    const Deferred<std::vector<int>> list("file", 4, [&] {
      ++made;
      std::this_thread::sleep_for(std::chrono::microseconds(100));
      return std::vector<int>(1000, 7);
    });
    fromManyThreads(list, [&](const auto& d) { right += d.get().at(999) == 7 ? 1 : 0; });
    EXPECT_EQ(made, 1);
    EXPECT_EQ(right, 8);
  }
}

TEST(Deferred, FailsAlikeForAll) {
  int tries = 0;
  const Deferred<int> broken(
      "file", 4, [&]() -> int { throw SceneError("broken " + std::to_string(++tries)); });
  std::atomic<int> told{0};
  fromManyThreads(broken, [&](const auto& d) {
    try {
      d.get();
    } catch (const SceneError& error) {
      told += std::string(error.what()) == "broken 1" ? 1 : 0;
    }
  });
  EXPECT_EQ(told, 8);
  EXPECT_EQ(tries, 1);
  EXPECT_FALSE(broken.isLoaded());
}

TEST(Deferred, FilesAreCountedOnce) {
  FileCache cache;
  DeferredFiles& files = DeferredFiles::of(cache);
  EXPECT_EQ(&files, &DeferredFiles::of(cache));
  const Deferred<int> a("a", 100, [] { return 1; }), otherA("a", 50, [] { return 2; }),
      b("b", 10, [] { return 3; });
  for (const Deferred<int>* file : {&a, &otherA, &b}) files.add(*file);
  EXPECT_EQ(files.count().unread, 2u);
  EXPECT_EQ(files.count().bytesUnread, 160);
  a.load();
  EXPECT_EQ(files.count().read, 1u);
  EXPECT_EQ(files.count().unread, 1u);
  EXPECT_EQ(files.count().bytesUnread, 60);
  files.loadAll();
  EXPECT_EQ(files.count().read, 2u);
  EXPECT_EQ(files.count().unread, 0u);
}

}  // namespace
}  // namespace brume
