// SPDX-License-Identifier: Apache-2.0
#include "main/signals.h"

#include <csignal>

namespace brume {
namespace {

// A handler may touch lock-free atomics and nothing else.
std::atomic<bool> stopRequested{false};
std::atomic<int> signalReceived{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

using Handler = void (*)(int);

void setHandlers(Handler handler) {
  std::signal(SIGINT, handler);
  std::signal(SIGTERM, handler);
  // Whoever has it ignored (nohup) wants the render to outlive the terminal.
  if (std::signal(SIGHUP, handler) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

extern "C" void onSignal(int signal) {
  signalReceived = signal;
  stopRequested = true;
  // From now on either signal has its usual effect.
  setHandlers(SIG_DFL);
}

}  // namespace

StopOnSignal::StopOnSignal() {
  setHandlers(onSignal);
  std::signal(SIGPIPE, SIG_IGN);
}
StopOnSignal::~StopOnSignal() {
  setHandlers(SIG_DFL);
  std::signal(SIGPIPE, SIG_DFL);
}
const std::atomic<bool>& StopOnSignal::stop() const { return stopRequested; }
int StopOnSignal::received() { return signalReceived; }

}  // namespace brume
