// SPDX-License-Identifier: Apache-2.0
// The memory of the process, as the system sees it.
#pragma once

#include <cstdint>

namespace brume {

/// Makes the peak of a render of many passes that of a few. Arrays of 256 KiB and more come from
/// the system and go back to it: left alone, glibc raises that size after the first of them is
/// freed; later ones then leave holes, and the peak creeps up by some percent. What is smaller
/// stays with the process: every pass needs it again, and to fault its pages in anew took a twelfth
/// of a pass.
void keepMemoryFlat();

/// Gives the system what was freed. Called after what is done now and then, as the writing of an
/// image is, so that its peak does not come on top of that of the passes.
void returnFreeMemory();

/// The most memory that the process has had so far [bytes].
std::uint64_t peakMemory();

}  // namespace brume
