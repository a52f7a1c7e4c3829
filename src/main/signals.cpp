// SPDX-License-Identifier: Apache-2.0
#include "main/signals.h"

#include <csignal>

namespace brume {
namespace {

// A handler may touch lock-free atomics and nothing else.
std::atomic<bool> stopRequested{false};
std::atomic<int> signalReceived{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

void setHandlers(void (*handler)(int)) {
  std::signal(SIGINT, handler);
  std::signal(SIGTERM, handler);
}

extern "C" void onSignal(int signal) {
  signalReceived = signal;
  stopRequested = true;
  // From now on either signal has its usual effect.
  setHandlers(SIG_DFL);
}

}  // namespace

StopOnSignal::StopOnSignal() { setHandlers(onSignal); }
StopOnSignal::~StopOnSignal() { setHandlers(SIG_DFL); }
const std::atomic<bool>& StopOnSignal::stop() const { return stopRequested; }
int StopOnSignal::received() { return signalReceived; }

}  // namespace brume
