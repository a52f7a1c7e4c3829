// SPDX-License-Identifier: Apache-2.0
#include "tools/child_process.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <new>

#include "core/error.h"

namespace brume {
namespace {

double seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

constexpr int kExitUserFault = 1, kExitOwnFault = 2;

/// The text of the present exception, and whose fault it is.
std::string describeException(int& exitCode) {
  exitCode = kExitUserFault;
  try {
    throw;
  } catch (const SceneError& error) {
    return error.where().isKnown() ? toString(error.where()) + ": " + error.what() : error.what();
  } catch (const std::bad_alloc&) {
    return "out of memory";
  } catch (const std::exception& error) {
    exitCode = kExitOwnFault;
    return std::string("internal error: ") + error.what();
  } catch (...) {
    exitCode = kExitOwnFault;
    return "internal error";
  }
}

/// The child's side: tells its fault through the pipe and never returns.
[[noreturn]] void workAsChild(const std::function<void()>& work, int pipeEnd, pid_t parent) {
#ifdef __linux__
  prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  if (getppid() != parent) _exit(kExitUserFault);  // it ended meanwhile
  int exitCode = 0;
  try {
    work();
  } catch (...) {
    const std::string text = describeException(exitCode);
    [[maybe_unused]] const auto written = write(pipeEnd, text.data(), text.size());
  }
  _exit(exitCode);
}

/// Signals by which the system answers a wrong program.
bool isCrash(int signal) {
  return signal == SIGSEGV || signal == SIGBUS || signal == SIGILL || signal == SIGFPE ||
         signal == SIGABRT;
}

std::string readAll(int descriptor) {
  std::string text;
  std::array<char, 4096> buffer;
  for (;;) {
    const ssize_t n = read(descriptor, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(n));
  }
}

}  // namespace

ChildOutcome runInChild(const std::function<void()>& work) {
  int ends[2];
  if (pipe(ends) != 0)
    throw SceneError(fmt::format("cannot make a pipe: {}", std::strerror(errno)));
  // A process that was started with this signal ignored would never learn how its child ended.
  std::signal(SIGCHLD, SIG_DFL);
  const pid_t parent = getpid(), child = fork();
  if (child < 0) {
    const int code = errno;
    close(ends[0]);
    close(ends[1]);
    throw SceneError(fmt::format("cannot start a process: {}", std::strerror(code)));
  }
  if (child == 0) workAsChild(work, ends[1], parent);

  close(ends[1]);
  ChildOutcome outcome;
  outcome.failure = readAll(ends[0]);
  close(ends[0]);
  int status = 0;
  rusage usage{};
  pid_t ended = -1;
  while ((ended = wait4(child, &status, 0, &usage)) < 0 && errno == EINTR) {
  }
  if (ended != child) {
    outcome.failure = fmt::format("cannot learn how its process ended: {}", std::strerror(errno));
    return outcome;
  }
  outcome.isDone = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    outcome.isFault = isCrash(signal);
    outcome.failure = fmt::format("ended by signal {} ({}){}", signal, strsignal(signal),
                                  signal == SIGKILL ? ", perhaps for want of memory" : "");
  } else if (!outcome.isDone) {
    outcome.isFault = WEXITSTATUS(status) == kExitOwnFault;
    if (outcome.failure.empty())
      outcome.failure = fmt::format("its process ended with exit code {}", WEXITSTATUS(status));
  }
  outcome.cpuSeconds = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  outcome.peakMemory = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts in KiB
  return outcome;
}

double processorSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace brume
