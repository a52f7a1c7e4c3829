// SPDX-License-Identifier: Apache-2.0
#include "main/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

namespace brume {
namespace {

/// "1.24 M": three digits and a prefix.
std::string countText(double n) {
  for (const auto& [scale, prefix] :
       {std::pair{1e9, "G"}, std::pair{1e6, "M"}, std::pair{1e3, "k"}})
    if (n >= scale) return fmt::format("{:.3g} {}", n / scale, prefix);
  return fmt::format("{:.3g} ", n);
}

}  // namespace

std::string durationText(double seconds) {
  if (seconds < 1) return fmt::format("{:.2f} s", seconds);
  if (seconds < 59.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<std::int64_t>(std::llround(std::min(seconds, 1e9)));
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string progressText(const RenderProgress& progress) {
  std::string text = fmt::format("{}{}{:5.1f} %", progress.what, progress.what.empty() ? "" : " ",
                                 100 * progress.fraction);
  if (progress.pass > 0) text += fmt::format("  pass {}", progress.pass);
  text += fmt::format("  {}", durationText(progress.seconds));
  if (progress.fraction > 0 && progress.fraction < 1) {
    const double left = progress.seconds * (1 - progress.fraction) / progress.fraction;
    text += fmt::format(", {} left", durationText(left));
  }
  if (progress.seconds > 0 && progress.rays > 0)
    text += fmt::format("  {}rays/s", countText(double(progress.rays) / progress.seconds));
  if (progress.seconds > 0 && progress.photons > 0)
    text += fmt::format("  {}photons/s", countText(double(progress.photons) / progress.seconds));
  if (progress.estimatedError) text += fmt::format("  error {:.2g}", *progress.estimatedError);
  return text;
}

ProgressLine::ProgressLine(Verbosity verbosity)
    : isQuiet_(verbosity == Verbosity::Quiet), isTerminal_(isatty(STDERR_FILENO) != 0) {}

ProgressLine::~ProgressLine() {
  if (isShown_ && isTerminal_) std::fputs("\r\x1b[K", stderr);
}

void ProgressLine::show(const RenderProgress& progress) {
  if (isQuiet_) return;
  if (isTerminal_) {
    std::fprintf(stderr, "\r%s\x1b[K", progressText(progress).c_str());
    std::fflush(stderr);
  } else if (progress.seconds >= nextLine_) {
    std::fprintf(stderr, "%s\n", progressText(progress).c_str());
    // A log of an hour has a dozen lines: each interval is half as long again as the one before.
    nextLine_ = 1.5 * std::max(progress.seconds, nextLine_);
  }
  isShown_ = true;
}

}  // namespace brume
