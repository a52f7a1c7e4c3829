// SPDX-License-Identifier: Apache-2.0
#include "main/process_memory.h"

#include <sys/resource.h>

#include <limits>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace brume {

void keepMemoryFlat() {
#ifdef __GLIBC__
  constexpr int kLargeArray = 256 << 10;
  mallopt(M_MMAP_THRESHOLD, kLargeArray);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
#endif
}

void returnFreeMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

std::uint64_t peakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::uint64_t(usage.ru_maxrss) * 1024;  // Linux counts in KiB
}

}  // namespace brume
