// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

namespace brume {

/// While one of these lives, the first SIGINT, SIGTERM or SIGHUP only asks the render to stop, so
/// that the image so far can be written; a second one ends the process at once, as does one at any
/// other time. A reader of the messages that goes away (SIGPIPE) does not end it. At most one lives
/// at a time.
class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  const std::atomic<bool>& stop() const;
  /// The signal that came, 0 for none. Exit codes are 128 + signal.
  static int received();
};

}  // namespace brume
