// SPDX-License-Identifier: Apache-2.0
// The photon tracer against what bounds it, and its maps against the tracer, on one thread:
//
//   brume_photon_tracing [--paths N] [--repeats N] [--rates-only] SCENE.pbrt ...
//
// The photons are those that bre and vpm ask for. Path segments per second; the rate at which
// Embree alone, without anything of brume's, answers the rays of all those segments in the same
// scene and order; the time to build each structure of the photon methods as a share of the time to
// trace its photons (not with --rates-only); bytes per photon. Processor time, the best of several,
// tracer and Embree in turn.
#include <dlfcn.h>
#include <embree3/rtcore.h>
#include <fmt/format.h>

#include <array>
#include <cstring>
#include <ctime>

#include "accelerators/photon_bvh.h"
#include "core/error.h"
#include "core/parallel.h"
#include "renderers/render_job.h"
#include "transport/beam_radiance.h"
#include "transport/photon_maps.h"
#include "transport/surface_photon_map.h"
#include "transport/volume_photon_map.h"

namespace {

using namespace brume;

/// A query as Embree got it. What follows the public context belongs to the caller.
struct RecordedRay {
  RTCScene scene;
  struct Context : RTCIntersectContext {
    float time;
  } context;
  RTCRayHit ray;
};

std::vector<RecordedRay> recorded;
bool isRecording = false;

using Intersect = void (*)(RTCScene, RTCIntersectContext*, RTCRayHit*);
const auto embreeIntersect = reinterpret_cast<Intersect>(dlsym(RTLD_NEXT, "rtcIntersect1"));

[[gnu::noinline]] void record(RTCScene scene, const RTCIntersectContext* context,
                              const RTCRayHit& ray) {
  RecordedRay r;
  r.scene = scene;
  std::memcpy(static_cast<void*>(&r.context), context, sizeof(RTCIntersectContext) + sizeof(float));
  r.ray = ray;
  recorded.push_back(r);
}

}  // namespace

// Stands before the library's function of this name; a jump to it where nothing is recorded.
extern "C" void rtcIntersect1(RTCScene scene, RTCIntersectContext* context, RTCRayHit* ray) {
  if (isRecording) [[unlikely]]
    record(scene, context, *ray);
  embreeIntersect(scene, context, ray);
}

namespace {

double processorSeconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

int repeats = 5;
bool ratesOnly = false;

/// Of f(), the least of several.
template <class F>
double best(F&& f) {
  double least = kInfinity;
  for (int i = 0; i < repeats; ++i) {
    const double begin = processorSeconds();
    f();
    least = std::min(least, processorSeconds() - begin);
  }
  return least;
}

/// Of all recorded queries, without the time to fetch them from memory.
double secondsOfEmbree() {
  constexpr std::size_t kBlock = 1024;
  static std::array<RecordedRay, kBlock> block;
  double seconds = 0;
  for (std::size_t first = 0; first < recorded.size(); first += kBlock) {
    const std::size_t n = std::min(kBlock, recorded.size() - first);
    std::copy_n(recorded.begin() + static_cast<std::ptrdiff_t>(first), n, block.begin());
    const double begin = processorSeconds();
    for (std::size_t i = 0; i < n; ++i)
      embreeIntersect(block[i].scene, &block[i].context, &block[i].ray);
    seconds += processorSeconds() - begin;
  }
  return seconds;
}

void print(const char* what, double seconds, double tracing, std::size_t photons,
           std::size_t bytes) {
  if (photons == 0) return;
  fmt::print("  {:<38} {:8.1f} ms  {:5.1f} % of tracing  {:5.0f} ns a photon", what, 1e3 * seconds,
             100 * seconds / tracing, 1e9 * seconds / static_cast<double>(photons));
  if (bytes > 0)
    fmt::print("  {:.2f} bytes", static_cast<double>(bytes) / static_cast<double>(photons));
  fmt::print("\n");
}

/// Every structure that a photon method builds, against the tracing of all photons.
void measureMaps(const Scene& scene, const std::vector<Photon>& photons, double tracing) {
  std::size_t bytes = 0, count = 0;
  if (scene.volume()) {
    const auto build = [&] {
      return VolumePhotonMap(*scene.volume(), photons, VolumePhotonMap::Power::Scattered);
    };
    double seconds = best([&] {
      const VolumePhotonMap map = build();
      count = map.size();
      bytes = map.memoryBytes();
    });
    print("volume kd-tree (vpm, bre)", seconds, tracing, count, bytes);
    if (count > 0) {
      const VolumePhotonMap map = build();
      std::vector<float> radii2;
      seconds = best([&] { radii2 = adaptiveRadii2(map.tree(), 50); });
      print("radii by 50 neighbours (bre)", seconds, tracing, count, 0);
      seconds =
          best([&] { bytes = PhotonBvh(map.tree(), radii2).memoryBytes() + map.memoryBytes(); });
      print("BVH over them (bre), with the tree", seconds, tracing, count, bytes);
      seconds = best([&] { VolumePhotons(*scene.volume(), photons); });
      print("order along a curve (pvpm)", seconds, tracing, count, 0);
    }
  }
  double seconds = best([&] {
    const SurfacePhotonMap map{std::span<const Photon>(photons)};
    count = map.photons().size();
  });
  print("surface kd-tree", seconds, tracing, count, 0);
}

void measure(const std::string& file, std::uint64_t paths) {
  Log log({Verbosity::Quiet, false, false});
  parseSceneFile(file, {}, log, [&](SceneDescription description) {
    const RenderJob job(std::move(description), RenderSettings{}, log);
    const Scene& scene = job.scene();
    PhotonRequest request;
    request.wanted =
        showableClasses(scene, {1, 1, false, {}});  // of bre and vpm, as they are by default
    const PhotonTracer tracer(scene, request);
    PathsPerClass perClass;
    perClass.fill(paths);
    const std::atomic<bool> stop{false};
    PhotonSet set;
    Stats stats;

    // All segments count, those for which the tracer need not ask Embree as well.
    request.looksEverywhere = true;
    const PhotonTracer asksAlways(scene, request);
    isRecording = true;
    asksAlways.trace(1, 0, perClass, stop, stats);
    isRecording = false;

    double tracing = kInfinity, embree = kInfinity;
    for (int i = 0; i < repeats; ++i) {
      const double begin = processorSeconds();
      set = tracer.trace(1, 0, perClass, stop, stats = {}, std::move(set));
      tracing = std::min(tracing, processorSeconds() - begin);
      embree = std::min(embree, secondsOfEmbree());
    }
    const auto segments = static_cast<double>(stats[Stat::PhotonSegments]);
    const auto rays = static_cast<double>(recorded.size());
    recorded = {};
    fmt::print("{}: {} light paths, {} photons\n", file, paths, set.photons.size());
    fmt::print("  {:.2f} M paths/s, {:.2f} M segments/s, {:.2f} M photons/s\n",
               1e-6 * static_cast<double>(paths) / tracing, 1e-6 * segments / tracing,
               1e-6 * static_cast<double>(set.photons.size()) / tracing);
    fmt::print("  Embree alone, the same {} rays: {:.2f} M rays/s; the tracer runs at {:.0f} %\n",
               static_cast<std::uint64_t>(rays), 1e-6 * rays / embree,
               100 * (segments / tracing) / (rays / embree));
    if (!ratesOnly) measureMaps(scene, set.photons, tracing);
  });
}

}  // namespace

int main(int argc, char** argv) try {
  setThreadCount(1);
  std::uint64_t paths = 200'000;
  std::vector<std::string> scenes;
  for (int i = 1; i < argc; ++i) {
    if (std::string_view(argv[i]) == "--paths" && i + 1 < argc)
      paths = std::strtoull(argv[++i], nullptr, 10);
    else if (std::string_view(argv[i]) == "--repeats" && i + 1 < argc)
      repeats = std::atoi(argv[++i]);
    else if (std::string_view(argv[i]) == "--rates-only")
      ratesOnly = true;
    else
      scenes.emplace_back(argv[i]);
  }
  for (const std::string& scene : scenes) measure(scene, paths);
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "{}\n", e.what());
  return 1;
}
