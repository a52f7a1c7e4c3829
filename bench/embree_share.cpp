// SPDX-License-Identifier: Apache-2.0
// How much of a render's time is spent inside Embree, and how many rays per second of processor
// time that makes.
//
//   brume_embree_share [--spp N] [--integrator NAME] SCENE.pbrt ...
//
// The processor's time is sampled: at each tick of the profiling clock the handler looks whether
// the program counter, or that of a caller, lies in Embree's library. Callbacks from Embree into
// brume (quadrics, alpha textures, moving instances) are part of the intersection and count as
// inside; their share is printed by itself as well.
#include <execinfo.h>
#include <fmt/format.h>
#include <link.h>
#include <signal.h>
#include <sys/time.h>
#include <ucontext.h>

#include <cstdlib>
#include <cstring>
#include <ctime>

#include "core/error.h"
#include "core/parallel.h"
#include "renderers/render_job.h"

namespace {

using namespace brume;

constexpr int kTicksPerSecond = 997;  // a prime: not in step with anything else

std::uintptr_t embreeBegin = 0, embreeEnd = 0;
std::atomic<std::uint64_t> ticks{0}, ticksInEmbree{0}, ticksInCallbacks{0};

bool isInEmbree(std::uintptr_t pc) { return pc >= embreeBegin && pc < embreeEnd; }

/// Finds the executable segments of Embree's library among those that are loaded.
int findEmbree(dl_phdr_info* info, std::size_t, void*) {
  if (!std::strstr(info->dlpi_name, "embree")) return 0;
  embreeBegin = ~std::uintptr_t{0};
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const auto& segment = info->dlpi_phdr[i];
    if (segment.p_type != PT_LOAD || !(segment.p_flags & PF_X)) continue;
    const std::uintptr_t begin = info->dlpi_addr + segment.p_vaddr;
    embreeBegin = std::min(embreeBegin, begin);
    embreeEnd = std::max(embreeEnd, begin + segment.p_memsz);
  }
  return 1;
}

void onTick(int, siginfo_t*, void* context) {
  const auto* machine = &static_cast<const ucontext_t*>(context)->uc_mcontext;
#if defined(__x86_64__)
  const auto pc = static_cast<std::uintptr_t>(machine->gregs[REG_RIP]);
#elif defined(__aarch64__)
  const auto pc = static_cast<std::uintptr_t>(machine->pc);
#endif
  ticks.fetch_add(1, std::memory_order_relaxed);
  if (isInEmbree(pc)) {
    ticksInEmbree.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  // A callback has Embree among its callers, a few frames up.
  void* callers[24];
  const int depth = backtrace(callers, std::size(callers));
  for (int i = 0; i < depth; ++i)
    if (isInEmbree(reinterpret_cast<std::uintptr_t>(callers[i]))) {
      ticksInCallbacks.fetch_add(1, std::memory_order_relaxed);
      return;
    }
}

/// The first call loads the unwinder, which a signal handler must not do.
void loadUnwinder() {
  void* callers[1];
  backtrace(callers, 1);
}

void setClock(int perSecond) {
  itimerval timer{};
  if (perSecond > 0) timer.it_interval.tv_usec = timer.it_value.tv_usec = 1000000 / perSecond;
  setitimer(ITIMER_PROF, &timer, nullptr);
}

/// Of all threads: what else runs on the machine counts less than by the clock.
double processorSeconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void measure(const std::string& file, const RenderSettings& settings) {
  Log::Options quiet;
  quiet.verbosity = Verbosity::Quiet;
  Log log(quiet);
  parseSceneFile(file, {}, log, [&](SceneDescription description) {
    RenderJob job(std::move(description), settings, log);
    ticks = ticksInEmbree = ticksInCallbacks = 0;
    const double begin = processorSeconds();
    setClock(kTicksPerSecond);
    const RenderResult result = job.run(std::atomic<bool>{false}, {});
    setClock(0);
    const double seconds = processorSeconds() - begin;
    const double all = std::max<double>(1, static_cast<double>(ticks));
    const double callbacks = static_cast<double>(ticksInCallbacks) / all;
    const double share = static_cast<double>(ticksInEmbree) / all + callbacks;
    const auto rays =
        static_cast<double>(result.stats[Stat::IntersectionRays] + result.stats[Stat::ShadowRays]);
    fmt::print(
        "{{\"scene\": \"{}\", \"seconds\": {:.2f}, \"ticks\": {}, \"embree_share\": {:.3f}, "
        "\"callback_share\": {:.3f}, \"rays_per_second\": {:.0f}, \"rays_per_second_in_embree\": "
        "{:.0f}}}\n",
        file, seconds, ticks.load(), share, callbacks, rays / seconds, rays / (seconds * share));
  });
}

}  // namespace

int main(int argc, char** argv) try {
  RenderSettings settings;
  settings.integrators = {"path"};
  settings.outputName = "embree_share.exr";
  std::vector<std::string> scenes;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--spp" && i + 1 < argc)
      settings.samplesPerPixel = std::atoi(argv[++i]);
    else if (argument == "--integrator" && i + 1 < argc)
      settings.integrators = {argv[++i]};
    else
      scenes.push_back(argument);
  }
  dl_iterate_phdr(findEmbree, nullptr);
  loadUnwinder();
  BRUME_CHECK(embreeEnd > embreeBegin);
  struct sigaction action {};
  action.sa_sigaction = onTick;
  action.sa_flags = SA_SIGINFO | SA_RESTART;
  sigaction(SIGPROF, &action, nullptr);
  for (const std::string& scene : scenes) measure(scene, settings);
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "{}\n", e.what());
  return 1;
}
