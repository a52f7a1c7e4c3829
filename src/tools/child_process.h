// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace brume {

/// What became of a piece of work that had a process of its own.
struct ChildOutcome {
  bool isDone = false;   ///< it returned
  std::string failure;   ///< else, and never empty: its exception, or the signal that ended it
  bool isFault = false;  ///< it failed by a fault of brume: an InternalError, a crash
  double cpuSeconds = 0;
  std::uint64_t peakMemory = 0;  ///< [bytes]
};

/// Runs `work` in a copy of this process and waits: what it changes in memory is lost, its faults
/// and its memory are its own. It does not outlive the calling process, which must not have started
/// threads.
ChildOutcome runInChild(const std::function<void()>& work);

/// Processor time that this process has taken so far, of all threads.
double processorSeconds();

}  // namespace brume
