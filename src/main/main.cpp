// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <string>

#include "core/parallel.h"
#include "main/command_line.h"
#include "main/failure.h"
#include "main/process_memory.h"
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
