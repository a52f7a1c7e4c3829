// SPDX-License-Identifier: Apache-2.0
#include "support/run_program.h"
#include "support/folders.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

#include <fcntl.h>

namespace brume::test {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kPatience{60};

/// The child's side of fork: never returns.
[[noreturn]] void becomeBrume(const ProgramInput& input, const fs::path& streams) {
  const auto redirect = [&](const char* name, int flags, int descriptor) {
    const int file = open((streams / name).c_str(), flags, 0600);
    if (file < 0 || dup2(file, descriptor) < 0) _exit(120);
  };
  redirect("in", O_RDONLY, STDIN_FILENO);
  redirect("out", O_WRONLY | O_CREAT, STDOUT_FILENO);
  redirect("err", O_WRONLY | O_CREAT, STDERR_FILENO);
  if (!input.workingFolder.empty() && chdir(input.workingFolder.c_str()) != 0) _exit(121);
  if (input.fileSizeLimit) {
    const rlimit limit{*input.fileSizeLimit, *input.fileSizeLimit};
    // Ignored, the signal turns into the error EFBIG of write().
    std::signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  std::vector<char*> words;
  std::string program = test::binaryFolder().string() + "/brume";
  words.push_back(program.data());
  std::vector<std::string> arguments = input.arguments;
  for (std::string& word : arguments) words.push_back(word.data());
  words.push_back(nullptr);
  execv(program.c_str(), words.data());
  _exit(122);
}

/// The first process that a process has started and that has not ended; 0 for none.
pid_t childOf(pid_t parent) {
  const std::string id = std::to_string(parent);
  std::ifstream children("/proc/" + id + "/task/" + id + "/children");
  pid_t child = 0;
  children >> child;
  return child;
}

}  // namespace

std::string readFile(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "brume test XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::runtime_error("cannot make a temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::string TemporaryFolder::write(const std::string& name, const std::string& text) const {
  const fs::path path = path_ / name;
  std::ofstream(path, std::ios::binary) << text;
  return path.string();
}

std::vector<std::string> TemporaryFolder::files() const {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(path_)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

ProgramResult runBrume(const ProgramInput& input) {
  const TemporaryFolder streams;
  streams.write("in", input.standardInput);
  const auto start = Clock::now();
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("cannot fork");
  if (child == 0) becomeBrume(input, streams.path());

  // Poll: short sleeps are precise enough for a test and need no second thread.
  int status = 0;
  bool isSignalDue = input.signal.has_value();
  rusage usage{};
  while (wait4(child, &status, WNOHANG, &usage) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    if (isSignalDue && readFile(streams.path() / "err").find(input.waitFor) != std::string::npos) {
      const pid_t target = input.signalsChild ? childOf(child) : child;
      if (target > 0) {
        kill(target, *input.signal);
        isSignalDue = false;
      }
    }
    if (Clock::now() - start > kPatience) kill(child, SIGKILL);
  }
  ProgramResult result;
  result.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  result.cpuSeconds = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  result.peakBytes = static_cast<std::size_t>(usage.ru_maxrss) * 1024;  // Linux counts in KiB
  result.exitCode = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  result.out = readFile(streams.path() / "out");
  result.err = readFile(streams.path() / "err");
  return result;
}

}  // namespace brume::test
