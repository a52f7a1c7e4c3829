// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <limits>
#include <string>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "core/parallel.h"
#include "main/command_line.h"
#include "main/failure.h"
#include "main/render_command.h"
#include "main/signals.h"

namespace {

using namespace brume;

/// Text that was asked for. A reader that went away or a full disk is an error, not silence.
void printResult(const std::string& text) {
  const bool isWritten = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!isWritten || std::fflush(stdout) != 0) throw SceneError("cannot write to standard output");
}

int run(const RenderCommand& command) { return runRender(command); }

int run(const DiffOptions& options) {
  const DiffOutcome outcome = compareImageFiles(options);
  printResult(outcome.text);
  return outcome.passed ? kExitDone : kExitUser;
}

int run(const PluginManualOptions& options) {
  printResult(pluginManual(options));
  return kExitDone;
}

int run(const PhotonReportOptions& options) {
  printResult(reportPhotons(options));
  return kExitDone;
}

int run(const RegressCommand& command) {
  setThreadCount(command.threads);
  Log log(command.log);
  const StopOnSignal signals;
  const RegressOutcome outcome =
      regress(command.options, log, signals.stop(), [&](const std::string& line) {
        const bool isWanted = command.log.verbosity != Verbosity::Quiet ||
                              line.starts_with("FAILED") || line.starts_with(" ");
        if (isWanted) printResult(line + "\n");
      });
  if (outcome.isInterrupted) return 128 + StopOnSignal::received();
  return outcome.passed() ? kExitDone : kExitUser;
}

int run(const BenchCommand& command) {
  const StopOnSignal signals;
  const BenchOutcome outcome = bench(command.options, signals.stop(), [&](const std::string& line) {
    const bool isWanted =
        !command.isQuiet || line.starts_with("FAILED") || line.starts_with("interrupted");
    if (isWanted) std::fprintf(stderr, "%s\n", line.c_str());
  });
  switch (outcome) {
    case BenchOutcome::Done:
      return kExitDone;
    case BenchOutcome::SomeFailed:
      return kExitUser;
    case BenchOutcome::SomeFaulty:
      return kExitInternal;
    case BenchOutcome::Interrupted:
      break;
  }
  return 128 + StopOnSignal::received();
}

int run(const ShowText& show) {
  printResult(show.text);
  return kExitDone;
}

/// Arrays of this size come from the system and go back to it. Left alone, glibc raises the size
/// after the first of them is freed; later ones then leave holes, and the peak of many passes
/// creeps up by some percent. What is smaller stays with the process: every pass needs it again,
/// and to fault its pages in anew took a twelfth of a pass.
constexpr int kLargeArray = 256 << 10;

void keepMemoryFlat() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, kLargeArray);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
#endif
}

}  // namespace

int main(int argc, char** argv) {
  keepMemoryFlat();
  try {
    return std::visit([](const auto& command) { return run(command); },
                      parseCommandLine(argc, argv));
  } catch (...) {
    return reportFailure();
  }
}
