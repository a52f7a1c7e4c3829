// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_tracer.h"

#include <fmt/format.h>

#include <numeric>

#include "core/bsdf.h"
#include "core/error.h"
#include "core/material.h"
#include "core/medium_along_ray.h"
#include "core/parallel.h"
#include "transport/aimed_scattering.h"

namespace brume {
namespace {

/// Paths of one chunk of work.
constexpr std::int64_t kChunk = 1024;
/// Scatterings after which every path meets roulette: without absorption, in a closed scene,
/// nothing else would end it.
constexpr int kLongPath = 10'000;
constexpr float kLongPathSurvival = 0.99f;

/// learnShares: paths of the mean in every source, and the part of the paths that is not moved.
constexpr double kPriorPaths = 16, kKeptShare = 0.1;

/// What a path has met so far.
enum class Stage { Direct, Specular, Scattered };

/// The classes that a path may still store.
PhotonClasses reachable(Stage stage) {
  constexpr PhotonClasses kIndirect = PhotonClass::SurfaceIndirect | PhotonClass::VolumeMultiple;
  constexpr PhotonClasses kCaustic = PhotonClass::SurfaceCaustic | PhotonClass::VolumeCaustic;
  switch (stage) {
    case Stage::Direct:
      return kSurfacePhotons | kVolumePhotons;
    case Stage::Specular:
      return kCaustic | kIndirect;
    case Stage::Scattered:
      break;
  }
  return kIndirect;
}

PhotonClass surfaceClass(Stage stage) {
  return stage == Stage::Direct     ? PhotonClass::SurfaceDirect
         : stage == Stage::Specular ? PhotonClass::SurfaceCaustic
                                    : PhotonClass::SurfaceIndirect;
}
PhotonClass volumeClass(Stage stage) {
  return stage == Stage::Direct     ? PhotonClass::VolumeUnscattered
         : stage == Stage::Specular ? PhotonClass::VolumeCaustic
                                    : PhotonClass::VolumeMultiple;
}

}  // namespace

struct PhotonTracer::Path {
  Ray ray;
  Rgb power;
  float usualPower = 0;
  Stage stage = Stage::Direct;
  int scatterings = 0;
  UniformFlights::Start start = UniformFlights::Start::Anywhere;
  std::optional<float> collision;  // distance along the ray, if that is how far it gets

  /// Roulette: goes on with `next`, the expected power, or ends. The survivors have the usual power
  /// at least.
  bool survives(const Rgb& next, float u) {
    float survival = std::min(1.f, largestChannel(next) / usualPower);
    if (scatterings >= kLongPath) survival = std::min(survival, kLongPathSurvival);
    if (!(survival > 0) || u >= survival) return false;
    power = survival < 1 ? next / survival : next;
    return true;
  }
};

PhotonTracer::PhotonTracer(const Scene& scene, const PhotonRequest& request)
    : scene_(scene),
      request_(request),
      uniform_(scene.volume() ? UniformFlights::through(*scene.volume()) : std::nullopt),
      media_(mediaToAimAt()),
      sources_(scene,
               {media_, !(request.wanted & kSurfacePhotons).isEmpty(), !request.passiveMedia}) {
  if (!scene.volume()) return;
  if (const MediumCoefficients* all = scene.volume()->proportions()) albedo_ = albedoOf(*all);
}

Ball PhotonTracer::mediaToAimAt() const {
  const Volume* volume = scene_.volume();
  if (!volume || (request_.wanted & kVolumePhotons).isEmpty()) return {};
  return ballAround(volume->bounds());
}

bool PhotonTracer::emit(PathRandom& random, Path& path) const {
  const auto start = sources_.sample(random);
  const float time = lerp(request_.shutter.t0, request_.shutter.t1, random.get1D());
  if (!start) return false;
  path.ray = Ray{start->o, start->d, kInfinity, time};
  path.power = start->power;
  path.usualPower = start->usualPower;
  if (start->isInMedium) {
    path.stage = Stage::Scattered;
    path.start = UniformFlights::Start::InMedium;
  }
  return true;
}

/// Absorbed, or scattered into a direction of the phase function.
bool PhotonTracer::scatterInMedium(Path& path, const Rgb& albedo, PathRandom& random) const {
  const float uSurvival = random.get1D(), uLobe = random.get1D();
  const Vec2 u = random.get2D();
  ++path.scatterings;
  if (!path.survives(path.power * albedo, uSurvival)) return false;
  const Vec3 p = path.ray(*path.collision);
  const ScatterSample sample = scene_.volume()->samplePhase(p, -path.ray.d, path.power, uLobe, u);
  if (!(sample.pdf > 0)) return false;
  path.power *= sample.value / sample.pdf;
  path.ray = Ray{p, sample.wi, kInfinity, path.ray.time};
  path.stage = Stage::Scattered;
  path.start = UniformFlights::Start::InMedium;
  return true;
}

/// Stores a photon on all but mirrors and glass, then goes on by the BSDF.
bool PhotonTracer::scatterAtSurface(Path& path, const SurfaceInteraction& at, PhotonClasses wanted,
                                    std::vector<Photon>& photons, PathRandom& random) const {
  Bsdf bsdf;
  at.material->evaluate(at, bsdf);
  const PhotonClass c = surfaceClass(path.stage);
  if (wanted.contains(c) && !bsdf.isSpecularOnly())
    photons.push_back(Photon::onSurface(at.p, at.wo, at.n, path.power, c));

  const float uLobe = random.get1D(), uSurvival = random.get1D();
  const Vec2 u = random.get2D();
  ++path.scatterings;
  const bool wantsMedia = !(reachable(Stage::Scattered) & wanted & kVolumePhotons).isEmpty();
  const auto sample = sampleTowards(bsdf, at, wantsMedia ? media_ : Ball{}, uLobe, u);
  if (!sample || !(sample->pdf > 0)) return false;

  // Light travels from wi = at.wo to the sampled direction; the BSDF is symmetric.
  const Vec3 &ns = bsdf.shadingNormal(), &ng = bsdf.geometricNormal();
  const float in = absDot(at.wo, ng), inShading = absDot(at.wo, ns), out = absDot(sample->wi, ng);
  if (!(in > 0) || !(out > 0)) return false;
  // Radiance is not scaled by eta^2 where it is refracted (PBRT-v2), so the power is.
  const float weight = inShading * out / in * sqr(sample->eta) / sample->pdf;
  if (!path.survives(path.power * sample->f * weight, uSurvival)) return false;
  path.ray = at.spawnRay(sample->wi);
  path.start = UniformFlights::Start::Anywhere;
  if (!sample->isSpecular())
    path.stage = Stage::Scattered;
  else if (path.stage == Stage::Direct)
    path.stage = Stage::Specular;
  return true;
}

std::optional<SurfaceInteraction> PhotonTracer::nextSurface(const Path& path, Stats& stats) const {
  return scene_.intersect(FootprintRay(path.ray), stats);
}

/// To the next surface, or to a collision before it, or out of the scene.
std::optional<SurfaceInteraction> PhotonTracer::fly(Path& path, MediumAlongRay& medium, Vec2 u,
                                                    Stats& stats) const {
  path.collision.reset();
  if (uniform_) return flyThroughUniform(path, u, stats);
  auto hit = nextSurface(path, stats);
  const Volume* volume = scene_.volume();
  if (!volume) return hit;
  if (hit) path.ray.tMax = distance(path.ray.o, hit->p);
  const auto range = volume->intersect(path.ray);
  if (!range) return hit;
  const Rgb channels = flightChannels(path.power);
  FreeFlight flight;
  if (volume->proportions() != nullptr) {
    flight = sampleFreeFlight(*volume, path.ray, *range, channels, u.x, u.y);
  } else {
    medium.assign(*volume, path.ray, *range);
    flight = sampleFreeFlight(medium, channels, u.x, u.y);
  }
  path.collision = flight.t;
  path.power *= flight.weight;
  return hit;
}

/// The flight first: surfaces behind its end need not be found.
std::optional<SurfaceInteraction> PhotonTracer::flyThroughUniform(Path& path, Vec2 u,
                                                                  Stats& stats) const {
  const auto flight = uniform_->sample(path.ray, path.start, path.power, u);
  if (!flight) return nextSurface(path, stats);
  if (flight->collides) path.ray.tMax = flight->range.t1;
  auto hit = nextSurface(path, stats);
  if (flight->collides && !hit) {
    path.collision = flight->range.t1;
    path.power *= uniform_->weightAtCollision(*flight);
  } else {
    path.power *= uniform_->weightAt(*flight, hit ? distance(path.ray.o, hit->p) : kInfinity);
  }
  return hit;
}

Rgb PhotonTracer::albedoAt(float t, const MediumAlongRay& medium) const {
  return albedo_ ? *albedo_ : albedoOf(medium.at(t));
}

void PhotonTracer::tracePath(PathRandom random, PhotonClasses wanted, std::vector<Photon>& photons,
                             Stats& stats) const {
  stats.add(Stat::PhotonPaths);
  Path path;
  if (!emit(random, path)) return;
  thread_local MediumAlongRay medium;  // reused, so that its memory is
  while (!(reachable(path.stage) & wanted).isEmpty()) {
    stats.add(Stat::PhotonSegments);
    // The numbers of a free flight are drawn in any case, so that later ones keep their dimension.
    const Vec2 u = random.get2D();
    const std::optional<SurfaceInteraction> hit = fly(path, medium, u, stats);
    if (!(largestChannel(path.power) > 0)) return;

    const bool mayScatter = !request_.maxDepth || path.scatterings < *request_.maxDepth;
    if (path.collision) {
      const float t = *path.collision;
      const PhotonClass c = volumeClass(path.stage);
      if (wanted.contains(c))
        photons.push_back(Photon::inMedium(path.ray(t), -path.ray.d, path.power, c));
      if (!mayScatter || request_.passiveMedia) return;
      if (!scatterInMedium(path, albedoAt(t, medium), random)) return;
    } else if (hit) {
      if (!mayScatter) wanted = wanted & kSurfacePhotons;
      if (!scatterAtSurface(path, *hit, wanted, photons, random) || !mayScatter) return;
    } else {
      return;
    }
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
    for (std::int64_t i = some; i < last; ++i)
      body(PathRandom(random, static_cast<std::uint32_t>(i),
                      points[static_cast<std::size_t>(i - some)]),
           i);
  }
}

}  // namespace

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
  forEachChunk(static_cast<std::int64_t>(count), kChunk,
               [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
                 if (stop.load(std::memory_order_relaxed)) return;
                 std::vector<Photon> photons;
                 Stats& part = parts[static_cast<std::size_t>(chunk)];
                 forEachPath(random, begin, end, [&](const PathRandom& path, std::int64_t i) {
                   const std::uint64_t before = part[Stat::PhotonSegments];
                   photons.clear();
                   tracePath(path, request_.wanted, photons, part);
                   const std::uint64_t segments = part[Stat::PhotonSegments] - before;
                   seen[static_cast<std::size_t>(i)] = {
                       sources_.sourceOf(path), square(photons),
                       1 + static_cast<double>(segments + photons.size())};
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
                              const std::atomic<bool>& stop, Stats& stats) const {
  PhotonSet set;
  set.paths = paths;
  if (!hasLights()) return set;
  const auto count = static_cast<std::int64_t>(*std::max_element(paths.begin(), paths.end()));
  const auto chunks = static_cast<std::size_t>((count + kChunk - 1) / kChunk);
  const PassRandom random(seed, pass);
  std::array<float, kPhotonClasses> share{};
  for (std::size_t c = 0; c < kPhotonClasses; ++c)
    share[c] = paths[c] > 0 ? static_cast<float>(1.0 / static_cast<double>(paths[c])) : 0.f;

  struct Chunk {
    std::vector<Photon> photons;
    Stats stats;
  };
  std::vector<Chunk> parts(chunks);
  forEachChunk(count, kChunk, [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
    if (stop.load(std::memory_order_relaxed)) return;
    thread_local std::vector<Photon> photons;  // reused, so that its memory is
    photons.clear();
    Chunk& part = parts[static_cast<std::size_t>(chunk)];
    forEachPath(random, begin, end, [&](const PathRandom& path, std::int64_t i) {
      tracePath(path, wantedOf(paths, static_cast<std::uint64_t>(i)) & request_.wanted, photons,
                part.stats);
    });
    for (Photon& photon : photons)
      photon.power *= share[static_cast<std::size_t>(photon.photonClass())];
    part.photons.assign(photons.begin(), photons.end());
  });
  set.isComplete = !stop.load(std::memory_order_relaxed);
  if (!set.isComplete) return set;

  std::size_t total = 0;
  for (const Chunk& part : parts) total += part.photons.size();
  set.photons.reserve(total);
  for (Chunk& part : parts) {
    set.photons.insert(set.photons.end(), part.photons.begin(), part.photons.end());
    part.photons = {};
    stats.merge(part.stats);
  }
  stats.add(Stat::PhotonsStored, total);
  return set;
}

}  // namespace brume
