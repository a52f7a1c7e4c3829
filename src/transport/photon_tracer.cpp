// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_tracer.h"

#include <fmt/format.h>

#include <bit>
#include <numeric>
#include <utility>

#include "core/bsdf.h"
#include "core/error.h"
#include "core/material.h"
#include "core/medium_along_ray.h"
#include "core/parallel.h"
#include "core/reuse.h"
#include "transport/aimed_scattering.h"

namespace brume {
namespace {

/// Paths of one chunk of work.
constexpr auto kChunk = static_cast<std::int64_t>(PathWave::kSize);
/// Scatterings after which every path meets roulette: without absorption, in a closed scene,
/// nothing else would end it.
constexpr int kLongPath = 10'000;
constexpr float kLongPathSurvival = 0.99f;

/// learnShares: paths of the mean in every source, and the part of the paths that is not moved.
constexpr double kPriorPaths = 16, kKeptShare = 0.1;

/// What a path may still store: before anything is met, after specular surfaces alone, after all
/// else. The first class on surfaces, or in media, is that of its next photon there.
constexpr PhotonClasses kAfterScattering =
    PhotonClass::SurfaceIndirect | PhotonClass::VolumeMultiple;
constexpr PhotonClasses kAfterSpecular =
    PhotonClass::SurfaceCaustic | PhotonClass::VolumeCaustic | kAfterScattering;
constexpr PhotonClasses kFromLight = kSurfacePhotons | kVolumePhotons;

PhotonClass nextClass(std::uint32_t canStore, PhotonClasses where) {
  return static_cast<PhotonClass>(std::countr_zero(canStore & where.bits()));
}

/// The largest probability to survive a path's next scattering.
float mostSurvivors(int scatterings) { return scatterings + 1 < kLongPath ? 1 : kLongPathSurvival; }

constexpr Bounds3 kEverywhere{Vec3(-kInfinity), Vec3(kInfinity)};

}  // namespace

/// The photons of one wave's paths, in the order in which they are left.
class PhotonTracer::Deposits {
 public:
  void clear() {
    photons_.clear();
    paths_.clear();
    ends_.fill(0);
  }
  void add(std::uint32_t path, const Photon& photon) {
    photons_.push_back(photon);
    paths_.push_back(path);
    ++ends_[path];
  }

  /// The photons in the order of their paths, those of one path in their order.
  void sortInto(std::vector<Photon>& sorted) {
    std::uint32_t sum = 0;
    for (std::uint32_t& end : ends_) sum += std::exchange(end, sum);
    sorted.resize(photons_.size());
    for (std::size_t i = 0; i < photons_.size(); ++i) sorted[ends_[paths_[i]]++] = photons_[i];
  }
  /// Among the sorted ones.
  std::span<const Photon> photonsOf(std::size_t path, const std::vector<Photon>& sorted) const {
    const std::uint32_t begin = path > 0 ? ends_[path - 1] : 0;
    return {sorted.data() + begin, ends_[path] - begin};
  }

 private:
  std::vector<Photon> photons_;
  std::vector<std::uint32_t> paths_;
  PathWave::Words ends_{};  // counts, until they are sorted
};

PhotonTracer::PhotonTracer(const Scene& scene, const PhotonRequest& request)
    : scene_(scene),
      request_(request),
      surfaces_(scene.accelerator().bounds()),
      uniform_(scene.volume() ? UniformFlights::through(*scene.volume()) : std::nullopt),
      media_(mediaToAimAt()),
      sources_(scene,
               {media_, !(request.wanted & kSurfacePhotons).isEmpty(), !request.passiveMedia}) {
  if (!scene.volume()) return;
  if (const MediumCoefficients* all = scene.volume()->proportions()) albedo_ = albedoOf(*all);
  henyeyGreenstein_ = scene.volume()->henyeyGreenstein();
}

Ball PhotonTracer::mediaToAimAt() const {
  const Volume* volume = scene_.volume();
  if (!volume || (request_.wanted & kVolumePhotons).isEmpty()) return {};
  return ballAround(volume->bounds());
}

/// Adds a path to the wave, unless it carries nothing.
void PhotonTracer::emit(PathRandom& random, PathWave& wave) const {
  const auto start = sources_.sample(random);
  const float time = lerp(request_.shutter.t0, request_.shutter.t1, random.get1D());
  if (!start) return;
  const std::size_t i = wave.count++;
  wave.o.set(i, start->o);
  wave.d.set(i, start->d);
  wave.time[i] = time;
  wave.power.set(i, start->power);
  wave.usualPower[i] = start->usualPower;
  wave.canStore[i] = (start->isInMedium ? kAfterScattering : kFromLight).bits();
  wave.isInMedium[i] = start->isInMedium ? 1 : 0;
  // The first flight and scattering are stratified, too.
  const Vec2 flight = random.get2D();
  wave.uChannel[i] = flight.x, wave.uDepth[i] = flight.y;
  wave.u1[i] = random.get1D();
  wave.u2[i] = random.get1D();
  const Vec2 direction = random.get2D();
  wave.ux[i] = direction.x, wave.uy[i] = direction.y;
  wave.keyLow[i] = static_cast<std::uint32_t>(random.key());
  wave.keyHigh[i] = static_cast<std::uint32_t>(random.key() >> 32);
  wave.isAlive[i] = 1;
}

/// To the next surface, or to a collision before it, or out of the scene.
std::optional<SurfaceInteraction> PhotonTracer::fly(PathWave& wave, std::size_t i,
                                                    Stats& stats) const {
  Ray ray{wave.o[i], wave.d[i], kInfinity, wave.time[i]};
  auto hit = scene_.intersect(FootprintRay(ray), stats);
  wave.t[i] = kInfinity;
  const Volume* volume = scene_.volume();
  if (!volume) return hit;
  if (hit) ray.tMax = distance(ray.o, hit->p);
  const auto range = volume->intersect(ray);
  if (!range) return hit;
  const Rgb power = wave.power[i], channels = flightChannels(power);
  FreeFlight flight;
  if (volume->proportions() != nullptr) {
    flight = sampleFreeFlight(*volume, ray, *range, channels, wave.uChannel[i], wave.uDepth[i]);
  } else {
    thread_local MediumAlongRay medium;  // reused, so that its memory is
    medium.assign(*volume, ray, *range);
    flight = sampleFreeFlight(medium, channels, wave.uChannel[i], wave.uDepth[i]);
    if (flight.t) wave.albedo.set(i, albedoOf(medium.at(*flight.t)));
  }
  wave.power.set(i, power * flight.weight);
  if (flight.t) wave.t[i] = *flight.t;
  return hit;
}

/// Surfaces are looked for where the flight gets, no farther.
std::optional<SurfaceInteraction> PhotonTracer::endUniformFlight(PathWave& wave, std::size_t i,
                                                                 Stats& stats) const {
  if (!wave.mayMeetSurface[i]) return std::nullopt;
  const Ray ray{wave.o[i], wave.d[i], wave.t[i], wave.time[i]};
  auto hit = scene_.intersect(FootprintRay(ray), stats);
  if (!hit) return hit;
  wave.t[i] = kInfinity;
  wave.power.set(i, wave.power[i] * uniform_->weightAt(distance(ray.o, hit->p), wave, i));
  return hit;
}

void PhotonTracer::depositInMedia(const PathWave& wave, Deposits& deposits) const {
  for (std::size_t i = 0; i < wave.count; ++i) {
    const PhotonClass c = nextClass(wave.canStore[i], kVolumePhotons);
    if (!wave.collides(i) || !PhotonClasses::fromBits(wave.wanted[i]).contains(c)) continue;
    const Rgb power = wave.power[i];
    if (largestChannel(power) > 0)
      deposits.add(wave.path[i], {wave.p[i], power, PackedDirection::fromBits(wave.wi[i]),
                                  static_cast<std::uint32_t>(c)});
  }
}

/// Absorbed, or scattered into a direction of the phase function.
void PhotonTracer::scatterInMedia(int scatterings, PathWave& wave) const {
  const bool ends = !mayScatter(scatterings) || request_.passiveMedia;
  rouletteInMedia(ends ? 0.f : mostSurvivors(scatterings), wave);
  if (ends) return;
  if (henyeyGreenstein_) {
    brume::scatterInMedia(*henyeyGreenstein_, kAfterScattering.bits(), wave);
    return;
  }
  for (std::size_t i = 0; i < wave.count; ++i) {
    if (!wave.collides(i) || !(wave.isAlive[i] > 0)) continue;
    const Vec3 p = wave.p[i];
    const Rgb power = wave.power[i];
    const ScatterSample sample =
        scene_.volume()->samplePhase(p, -wave.d[i], power, wave.u2[i], {wave.ux[i], wave.uy[i]});
    wave.isAlive[i] = sample.pdf > 0 ? 1.f : 0.f;
    if (!(sample.pdf > 0)) continue;
    wave.power.set(i, power * (sample.value / sample.pdf));
    wave.o.set(i, p);
    wave.d.set(i, sample.wi);
    wave.isInMedium[i] = 1;
    wave.canStore[i] = kAfterScattering.bits();
  }
}

/// Stores a photon on all but mirrors and glass, then goes on by the BSDF.
bool PhotonTracer::scatterAtSurface(PathWave& wave, std::size_t i, const SurfaceInteraction& at,
                                    int scatterings, Deposits& deposits) const {
  Bsdf bsdf;
  at.material->evaluate(at, bsdf);
  const auto wanted = PhotonClasses::fromBits(wave.wanted[i]);
  const Rgb power = wave.power[i];
  const PhotonClass c = nextClass(wave.canStore[i], kSurfacePhotons);
  if (wanted.contains(c) && !bsdf.isSpecularOnly())
    deposits.add(wave.path[i], Photon::onSurface(at.p, at.wo, at.n, power, c));
  if (!mayScatter(scatterings)) return false;

  const bool wantsMedia = wanted.contains(PhotonClass::VolumeMultiple);
  const auto sample =
      sampleTowards(bsdf, at, wantsMedia ? media_ : Ball{}, wave.u1[i], {wave.ux[i], wave.uy[i]});
  if (!sample || !(sample->pdf > 0)) return false;

  // Light travels from wi = at.wo to the sampled direction; the BSDF is symmetric.
  const Vec3 &ns = bsdf.shadingNormal(), &ng = bsdf.geometricNormal();
  const float in = absDot(at.wo, ng), inShading = absDot(at.wo, ns), out = absDot(sample->wi, ng);
  if (!(in > 0) || !(out > 0)) return false;
  // Radiance is not scaled by eta^2 where it is refracted (PBRT-v2), so the power is.
  const float weight = inShading * out / in * sqr(sample->eta) / sample->pdf;
  const Rgb next = power * sample->f * weight;
  const float survival =
      std::min(mostSurvivors(scatterings), largestChannel(next) / wave.usualPower[i]);
  if (!(survival > 0) || wave.u2[i] >= survival) return false;
  wave.power.set(i, next / survival);
  wave.o.set(i, at.offsetOrigin(sample->wi));
  wave.d.set(i, sample->wi);
  wave.isInMedium[i] = 0;
  wave.canStore[i] &= (sample->isSpecular() ? kAfterSpecular : kAfterScattering).bits();
  return true;
}

/// The segments' ends on surfaces; collisions are left for later.
void PhotonTracer::meetSurfaces(int scatterings, PathWave& wave, Deposits& deposits,
                                Stats& stats) const {
  for (std::size_t i = 0; i < wave.count; ++i) {
    const auto hit = uniform_ ? endUniformFlight(wave, i, stats) : fly(wave, i, stats);
    if (wave.collides(i)) continue;
    const bool goesOn = hit && largestChannel(wave.power[i]) > 0 &&
                        scatterAtSurface(wave, i, *hit, scatterings, deposits);
    wave.isAlive[i] = goesOn ? 1.f : 0.f;
  }
}

/// All segments of the paths of a wave, which holds their starts; counts them for each.
void PhotonTracer::traceWave(PathWave& wave, Deposits& deposits, Stats& stats,
                             PathWave::Words* segments) const {
  for (int scatterings = 0;; ++scatterings) {
    dropEnded(wave);
    if (wave.count == 0) return;
    stats.add(Stat::PhotonSegments, wave.count);
    if (segments)
      for (std::size_t i = 0; i < wave.count; ++i) ++(*segments)[wave.path[i]];

    // The first flight and scattering have numbers of their own.
    if (scatterings > 0) drawNumbers(4 * (static_cast<std::uint64_t>(scatterings) - 1), wave);
    if (uniform_) {
      uniform_->sample(wave);
      findSegmentsNear(request_.looksEverywhere ? kEverywhere : surfaces_, wave);
    }
    meetSurfaces(scatterings, wave, deposits, stats);
    if (!scene_.volume()) continue;
    if (uniform_) uniform_->weighCollisions(wave);
    arriveInMedia(wave);
    depositInMedia(wave, deposits);
    scatterInMedia(scatterings, wave);
  }
}

namespace {

/// The classes that path number `index` counts for.
PhotonClasses wantedOf(const PathsPerClass& paths, std::uint64_t index) {
  PhotonClasses wanted;
  for (std::size_t c = 0; c < kPhotonClasses; ++c)
    if (index < paths[c]) wanted = wanted | static_cast<PhotonClass>(c);
  return wanted;
}

/// Calls body(PathRandom, i) for the paths [begin, end) of a pass.
template <class Body>
void forEachPath(const PassRandom& random, std::int64_t begin, std::int64_t end, const Body& body) {
  for (std::int64_t some = begin; some < end; some += PassRandom::kAtOnce) {
    const auto points = random.points(static_cast<std::uint32_t>(some));
    const std::int64_t last = std::min<std::int64_t>(end, some + PassRandom::kAtOnce);
    for (std::int64_t i = some; i < last; ++i) {
      PathRandom path(random, static_cast<std::uint32_t>(i),
                      points[static_cast<std::size_t>(i - some)]);
      body(path, i);
    }
  }
}

}  // namespace

/// The paths [begin, end) of a pass, kChunk at most.
void PhotonTracer::traceChunk(const PassRandom& random, std::int64_t begin, std::int64_t end,
                              const PathsPerClass& paths, Deposits& deposits, Stats& stats,
                              PathWave::Words* segments) const {
  thread_local PathWave wave;
  wave.count = 0;
  if (albedo_) wave.albedo.fill(*albedo_);
  deposits.clear();
  stats.add(Stat::PhotonPaths, static_cast<std::uint64_t>(end - begin));
  // The first paths of a pass may be wanted for more than later ones.
  const auto first = static_cast<std::uint64_t>(begin), last = static_cast<std::uint64_t>(end) - 1;
  const PhotonClasses wanted = wantedOf(paths, first) & request_.wanted;
  const bool isOfAll = (wantedOf(paths, last) & request_.wanted).bits() == wanted.bits();
  forEachPath(random, begin, end, [&](PathRandom& path, std::int64_t i) {
    wave.wanted[wave.count] =
        isOfAll ? wanted.bits()
                : (wantedOf(paths, static_cast<std::uint64_t>(i)) & request_.wanted).bits();
    wave.path[wave.count] = static_cast<std::uint32_t>(i - begin);
    emit(path, wave);
  });
  traceWave(wave, deposits, stats, segments);
}

std::optional<std::vector<float>> PhotonTracer::learnShares(std::uint64_t seed, std::uint64_t pass,
                                                            std::uint64_t count,
                                                            const SquareOfPath& square,
                                                            const std::atomic<bool>& stop,
                                                            Stats& stats) const {
  if (sources_.count() < 2) return std::nullopt;
  struct Seen {
    std::size_t source = 0;
    double square = 0, cost = 0;
  };
  std::vector<Seen> seen(count);
  std::vector<Stats> parts((count + kChunk - 1) / kChunk);
  const PassRandom random(seed, pass);
  PathsPerClass paths;
  paths.fill(count);
  forEachChunk(static_cast<std::int64_t>(count), kChunk,
               [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
                 if (stop.load(std::memory_order_relaxed)) return;
                 Deposits deposits;
                 PathWave::Words segments{};
                 traceChunk(random, begin, end, paths, deposits,
                            parts[static_cast<std::size_t>(chunk)], &segments);
                 std::vector<Photon> photons;
                 deposits.sortInto(photons);
                 forEachPath(random, begin, end, [&](const PathRandom& path, std::int64_t i) {
                   const auto inChunk = static_cast<std::size_t>(i - begin);
                   const auto left = deposits.photonsOf(inChunk, photons);
                   seen[static_cast<std::size_t>(i)] = {
                       sources_.sourceOf(path), square(left),
                       1 + static_cast<double>(segments[inChunk] + left.size())};
                 });
               });
  if (stop.load(std::memory_order_relaxed)) return std::nullopt;
  for (const Stats& part : parts) stats.merge(part);

  std::vector<Seen> sums(sources_.count());
  Seen mean;
  for (const Seen& path : seen) {
    sums[path.source].square += path.square;
    sums[path.source].cost += path.cost;
    mean.square += path.square / static_cast<double>(count);
    mean.cost += path.cost / static_cast<double>(count);
  }
  if (!(mean.square > 0)) return std::nullopt;
  std::vector<double> learnt;
  for (std::size_t s = 0; s < sums.size(); ++s)
    learnt.push_back(double{sources_.share(s)} *
                     std::sqrt((sums[s].square + kPriorPaths * mean.square) /
                               (sums[s].cost + kPriorPaths * mean.cost)));
  const double all = std::accumulate(learnt.begin(), learnt.end(), 0.);
  std::vector<float> shares;
  for (std::size_t s = 0; s < sums.size(); ++s)
    shares.push_back(static_cast<float>((1 - kKeptShare) * learnt[s] / all +
                                        kKeptShare * double{sources_.share(s)}));
  return shares;
}

PhotonSet PhotonTracer::trace(std::uint64_t seed, std::uint64_t pass, const PathsPerClass& paths,
                              const std::atomic<bool>& stop, Stats& stats, PhotonSet old,
                              const std::function<void(double)>& onShare) const {
  PhotonSet set = std::move(old);
  set.paths = paths;
  set.isComplete = true;
  if (!hasLights()) {
    set.photons.clear();
    return set;
  }
  const auto count = static_cast<std::int64_t>(*std::max_element(paths.begin(), paths.end()));
  const auto chunks = static_cast<std::size_t>((count + kChunk - 1) / kChunk);
  const PassRandom random(seed, pass);
  std::array<float, kPhotonClasses> share{};
  for (std::size_t c = 0; c < kPhotonClasses; ++c)
    share[c] = paths[c] > 0 ? static_cast<float>(1.0 / static_cast<double>(paths[c])) : 0.f;

  struct Chunk {
    std::vector<Photon> photons;
    std::size_t before = 0;  // photons of the chunks before it
    Stats stats;
  };
  std::vector<Chunk> parts(chunks);
  std::atomic<std::size_t> done = 0;
  forEachChunk(count, kChunk, [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
    if (stop.load(std::memory_order_relaxed)) return;
    thread_local Deposits deposits;  // reused, so that its memory is
    Chunk& part = parts[static_cast<std::size_t>(chunk)];
    traceChunk(random, begin, end, paths, deposits, part.stats, nullptr);
    deposits.sortInto(part.photons);
    for (Photon& photon : part.photons)
      photon.power *= share[static_cast<std::size_t>(photon.photonClass())];
    if (onShare) onShare(static_cast<double>(++done) / static_cast<double>(chunks));
  });
  set.isComplete = !stop.load(std::memory_order_relaxed);
  if (!set.isComplete) return set;

  std::size_t total = 0;
  for (Chunk& part : parts) {
    part.before = total;
    total += part.photons.size();
    stats.merge(part.stats);
  }
  resizeForReuse(set.photons, total);
  constexpr std::int64_t kMovedAtOnce = 64;  // chunks
  forEachChunk(static_cast<std::int64_t>(chunks), kMovedAtOnce,
               [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end);
                      ++i) {
                   Chunk& part = parts[i];
                   std::copy(part.photons.begin(), part.photons.end(),
                             set.photons.begin() + static_cast<std::ptrdiff_t>(part.before));
                   part.photons = {};
                 }
               });
  stats.add(Stat::PhotonsStored, total);
  return set;
}

}  // namespace brume
