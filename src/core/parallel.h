// SPDX-License-Identifier: Apache-2.0
// Parallel loops over chunks of fixed size; the one pair of files that knows TBB.
#pragma once

#include <cstdint>
#include <functional>

namespace brume {

/// Limits all loops of this process to n threads (0: as many as the machine has). main() calls it
/// once.
void setThreadCount(int n);
int threadCount();

/// Calls body(begin, end, chunk) for every chunk [begin, end) of [0, count). Chunk borders depend
/// on chunkSize alone, never on the number of threads. The first exception thrown by a body is
/// rethrown here after the others have ended.
void forEachChunk(
    std::int64_t count, std::int64_t chunkSize,
    const std::function<void(std::int64_t begin, std::int64_t end, std::int64_t chunk)>& body);

/// Runs body with parallel loops inside it (of a library too) on the calling thread alone, so that
/// what they build cannot depend on the number of threads.
void runSerially(const std::function<void()>& body);

}  // namespace brume
