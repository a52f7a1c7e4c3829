// SPDX-License-Identifier: Apache-2.0
#include "tools/child_process.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "core/error.h"

namespace brume {
namespace {

double seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

/// The child's side: tells its fault through the pipe and never returns.
[[noreturn]] void workAsChild(const std::function<void()>& work, int pipeEnd) {
  try {
    work();
    _exit(0);
  } catch (const std::exception& error) {
    const std::string text = error.what();
    [[maybe_unused]] const auto written = write(pipeEnd, text.data(), text.size());
  } catch (...) {
  }
  _exit(1);
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
  const pid_t child = fork();
  if (child < 0) throw SceneError(fmt::format("cannot start a process: {}", std::strerror(errno)));
  if (child == 0) workAsChild(work, ends[1]);

  close(ends[1]);
  ChildOutcome outcome;
  outcome.failure = readAll(ends[0]);
  close(ends[0]);
  int status = 0;
  rusage usage{};
  while (wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  outcome.isDone = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (WIFSIGNALED(status))
    outcome.failure =
        fmt::format("ended by signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)));
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
