// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_maps.h"

#include <fmt/format.h>

#include <cmath>

#include "core/log.h"
#include "core/plan.h"
#include "transport/photon_demand.h"
#include "transport/photon_quota.h"

namespace brume {
namespace {

/// Paths per photon asked for, where the pilot saw nearly none.
constexpr std::uint64_t kShortagePaths = 4;

/// Of either pilot that tells where light paths should start.
constexpr std::uint64_t kSharesPaths = 10'000;

/// Number of paths from which all classes of the group together store `photons`; none: the pilot
/// saw next to nothing.
std::optional<std::uint64_t> pathsOfGroup(const PathsPerClass& paths, PhotonClasses group,
                                          std::uint64_t photons) {
  // Each class alone would need paths[c], so it yields photons / paths[c] a path.
  double yield = 0;
  for (std::size_t c = 0; c < kPhotonClasses; ++c)
    if (group.contains(static_cast<PhotonClass>(c)) && paths[c] > 0)
      yield += static_cast<double>(photons) / static_cast<double>(paths[c]);
  if (!(yield > 0)) return std::nullopt;
  return static_cast<std::uint64_t>(std::ceil(static_cast<double>(photons) / yield));
}

std::uint64_t countOf(const PhotonSet& set, PhotonClasses group) {
  std::uint64_t n = 0;
  for (const Photon& photon : set.photons) n += group.contains(photon.photonClass()) ? 1 : 0;
  return n;
}

/// Light paths start where the photons come from that the image will look up.
void learnShares(PhotonTracer& tracer, PhotonClasses wanted, const Scene& scene,
                 const PrepareContext& context) {
  constexpr std::uint64_t kDemandPass = ~std::uint64_t{1}, kSharesPass = ~std::uint64_t{2};
  if (!tracer.hasShares()) return;
  PathsPerClass paths{};
  for (std::size_t c = 0; c < kPhotonClasses; ++c)
    if (wanted.contains(static_cast<PhotonClass>(c))) paths[c] = kSharesPaths;
  const PhotonSet pilot =
      tracer.trace(context.seed, kDemandPass, paths, context.stop, context.stats);
  if (!pilot.isComplete) return;
  const PhotonDemand demand(scene, *context.view, pilot.photons, context.seed, context.stats);
  if (demand.isEmpty()) return;
  const auto square = [&demand](std::span<const Photon> photons) {
    return demand.squareOf(photons);
  };
  const auto shares = tracer.learnShares(context.seed, kSharesPass, kSharesPaths, square,
                                         context.stop, context.stats);
  if (shares) tracer.setShares(*shares);
}

}  // namespace

PhotonClasses showableClasses(const Scene& scene, const PhotonMapRequest& request) {
  const SceneInventory inventory = takeInventory(scene);
  const bool hasSpecular = inventory.specularMaterials > 0;
  bool hasDiffuse = false;
  for (const auto& material : scene.contents().materials)
    hasDiffuse = hasDiffuse || material->hasNonSpecular();
  PhotonClasses classes;
  if (inventory.mediaScatter && request.volumePhotons > 0) {
    classes = classes | PhotonClass::VolumeMultiple;
    if (hasSpecular) classes = classes | PhotonClass::VolumeCaustic;
    if (request.unscatteredVolume) classes = classes | PhotonClass::VolumeUnscattered;
  }
  const bool hasSurfaces = inventory.meshes + inventory.quadrics > 0;
  if (hasDiffuse && hasSurfaces && request.surfacePhotons > 0) {
    classes = classes | PhotonClass::SurfaceIndirect;
    if (hasSpecular) classes = classes | PhotonClass::SurfaceCaustic;
  }
  return classes;
}

void planSkippedPhotons(const Scene& scene, Plan& plan) {
  if (takeInventory(scene).specularMaterials == 0)
    plan.skip("caustic photons", "no surface is specular");
  if (!scene.contents().unsampledLights.empty())
    plan.skip("photons of lights inside of object instances", "they show themselves, no more");
}

PhotonSet tracePhotons(const Scene& scene, const PhotonMapRequest& request,
                       const PrepareContext& context) {
  const PhotonClasses wanted = showableClasses(scene, request);
  PhotonTracer tracer(scene, {wanted, context.shutter, request.maxDepth});
  if (wanted.isEmpty() || !tracer.hasLights()) return {};
  const PhotonMapTracing tracing(context);
  if (context.view) learnShares(tracer, wanted, scene, context);

  // What each class would need by itself, then what the classes of a group need together.
  const std::array<std::pair<PhotonClasses, std::uint64_t>, 2> groups{
      {{wanted & kVolumePhotons, request.volumePhotons},
       {wanted & kSurfacePhotons, request.surfacePhotons}}};
  PhotonCounts counts{};
  for (const auto& [group, photons] : groups)
    for (std::size_t c = 0; c < kPhotonClasses; ++c)
      if (group.contains(static_cast<PhotonClass>(c))) counts[c] = photons;
  PathsPerClass paths = pathsFor(tracer, counts, wanted, context.seed, context.stop, context.stats,
                                 tracing.secondsForPilots());
  for (const auto& [group, photons] : groups) {
    const std::uint64_t needed =
        pathsOfGroup(paths, group, photons).value_or(kShortagePaths * photons);
    for (std::size_t c = 0; c < kPhotonClasses; ++c)
      if (group.contains(static_cast<PhotonClass>(c))) paths[c] = needed;
  }

  PhotonSet set = tracing.trace(tracer, paths);
  if (!set.isComplete) return set;
  for (const auto& [group, photons] : groups) {
    if (group.isEmpty()) continue;
    const std::uint64_t stored = countOf(set, group);
    const char* where =
        group.contains(PhotonClass::VolumeMultiple) ? "in the media" : "on surfaces";
    context.log.verbose(fmt::format("{} photons stored {}", stored, where));
    if (stored == 0 && group.contains(PhotonClass::VolumeUnscattered))
      throw SceneError("no photon could be stored in the media: no light reaches them");
    if (stored < photons / 2)
      context.log.verbose(
          fmt::format("fewer than the {} asked for: little light gets {}", photons, where));
  }
  return set;
}

void warnOfMotion(const Scene& scene, const PrepareContext& context) {
  if (scene.isMoving() && context.shutter.t1 > context.shutter.t0)
    context.log.warning({},
                        "photons on surfaces that move are spread over their way while the "
                        "shutter is open, so that too little caustic and indirect light is "
                        "found there; \"pvpm\" gives each pass a moment of its own");
}

}  // namespace brume
