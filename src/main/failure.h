// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace brume {

inline constexpr int kExitDone = 0, kExitUser = 1, kExitInternal = 2;

/// Prints the exception that is being handled to standard error and returns the exit code for it:
/// the user's faults and a machine too small for the scene are 1, everything else is 2.
int reportFailure();

}  // namespace brume
