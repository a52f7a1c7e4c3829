// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/log.h"
#include "renderers/render_job.h"

namespace brume {

/// Shows on standard error how far a render is: one line that is updated on a terminal, otherwise
/// plain lines at growing intervals; nothing when quiet.
class ProgressLine {
 public:
  /// Looks at standard error to choose between the two forms.
  explicit ProgressLine(Verbosity verbosity);
  /// Clears the line on a terminal.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(const RenderProgress& progress);

 private:
  bool isQuiet_ = false, isTerminal_ = false, isShown_ = false;
  double nextLine_ = 2;  ///< when the next plain line is due [s]
};

/// " 42.0 %  pass 2  0:12, 0:17 left  1.24 Mrays/s  error 0.031".
std::string progressText(const RenderProgress& progress);
/// "0.42 s", "12.3 s", "4:05", "1:02:03".
std::string durationText(double seconds);

}  // namespace brume
