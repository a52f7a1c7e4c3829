// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace brume {

namespace {

// The limit lives as long as the process; it is replaced, never removed.
std::unique_ptr<tbb::global_control>& limit() {
  static std::unique_ptr<tbb::global_control> control;
  return control;
}
int requestedThreads = 0;

}  // namespace

void setThreadCount(int n) {
  requestedThreads = n;
  limit().reset();
  if (n > 0)
    limit() = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    static_cast<std::size_t>(n));
}

int threadCount() {
  if (requestedThreads > 0) return requestedThreads;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

#ifdef BRUME_PLAIN_THREADS
// For the thread sanitizer, which does not see how TBB's library hands work and results over.
void forEachChunk(std::int64_t count, std::int64_t chunkSize,
                  const std::function<void(std::int64_t, std::int64_t, std::int64_t)>& body) {
  if (count <= 0) return;
  const std::int64_t chunks = (count + chunkSize - 1) / chunkSize;
  std::atomic<std::int64_t> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  const auto work = [&] {
    try {
      for (std::int64_t chunk; (chunk = next.fetch_add(1)) < chunks;)
        body(chunk * chunkSize, std::min(count, (chunk + 1) * chunkSize), chunk);
    } catch (...) {
      next = chunks;
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::int64_t i = 1; i < std::min<std::int64_t>(threadCount(), chunks); ++i)
      others.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
}
#else
namespace {

/// The one arena of all loops, of its own size: more threads than cores are really started, so that
/// tests of 7 threads test them. It is kept from loop to loop: TBB frees an arena late, and one for
/// each loop let the memory of long renders grow by some 5 kB a loop.
tbb::task_arena& arena() {
  static std::mutex mutex;
  static std::unique_ptr<tbb::task_arena> kept;
  const std::lock_guard lock(mutex);
  if (!kept || kept->max_concurrency() != threadCount())
    kept = std::make_unique<tbb::task_arena>(threadCount());
  return *kept;
}

}  // namespace

void forEachChunk(std::int64_t count, std::int64_t chunkSize,
                  const std::function<void(std::int64_t, std::int64_t, std::int64_t)>& body) {
  if (count <= 0) return;
  const std::int64_t chunks = (count + chunkSize - 1) / chunkSize;
  arena().execute([&] {
    tbb::parallel_for(
        std::int64_t{0}, chunks,
        [&](std::int64_t chunk) {
          body(chunk * chunkSize, std::min(count, (chunk + 1) * chunkSize), chunk);
        },
        tbb::simple_partitioner());
  });
}
#endif

void runSerially(const std::function<void()>& body) {
  tbb::task_arena arena(1);
  arena.execute(body);
}

}  // namespace brume
