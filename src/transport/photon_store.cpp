// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_store.h"

#include <fmt/format.h>

#include <optional>

#include "core/log.h"
#include "transport/photon_file.h"

namespace brume {
namespace {

/// Share of the scene's size by which photons may lie beyond its bounds: rounding, no more.
constexpr float kMargin = 1e-3f;

/// A photon far from all that the scene holds belongs to another scene.
void checkPlace(const std::vector<Photon>& photons, const Scene& scene, const std::string& name,
                Log& log) {
  Bounds3 bounds = scene.bounds();
  if (bounds.isEmpty()) return;
  const Vec3 margin(kMargin * bounds.radius());
  bounds.lo -= margin;
  bounds.hi += margin;
  const auto outside = std::count_if(photons.begin(), photons.end(),
                                     [&](const Photon& p) { return !bounds.contains(p.p); });
  if (outside > 0)
    log.warning({}, fmt::format("{} of the {} photons in '{}' lie outside of the scene: were they "
                                "traced in another one?",
                                outside, photons.size(), name));
}

PhotonSet load(const std::string& name, const PhotonNeeds& needs, const Scene& scene, Log& log) {
  PhotonFile file = readPhotonFile(name);
  file.moveTo(scene.sceneOrigin());
  PhotonSet& set = file.set;
  const PhotonClasses used = needs.required | needs.optional;
  for (std::size_t c = 0; c < kPhotonClasses; ++c) {
    const auto photonClass = static_cast<PhotonClass>(c);
    if (needs.required.contains(photonClass) && set.paths[c] == 0)
      throw SceneError(fmt::format("'{}' holds no photons {}, which this method needs", name,
                                   describe(photonClass)));
    if (!used.contains(photonClass)) set.paths[c] = 0;
  }
  std::erase_if(set.photons, [&](const Photon& p) { return !used.contains(p.photonClass()); });
  checkPlace(set.photons, scene, name, log);
  log.verbose(fmt::format("read {} photons from '{}'", set.photons.size(), name));
  return std::move(file.set);
}

}  // namespace

PhotonSet loadOrTracePhotons(const PhotonFileParams& files, const PhotonNeeds& needs,
                             const Scene& scene, const PrepareContext& context,
                             const std::function<PhotonSet()>& trace) {
  // What cannot be written shows before the work is done.
  std::optional<AtomicFile> output;
  if (!files.savephotons.empty()) output.emplace(files.savephotons);

  PhotonSet set;
  if (files.loadphotons.empty()) {
    set = trace();
  } else {
    set = load(files.loadphotons, needs, scene, context.log);
    context.stats.add(Stat::PhotonsStored, set.photons.size());
  }
  if (!output || !set.isComplete) return set;
  PhotonFile file{std::move(set), scene.sceneOrigin(), context.seed};
  encodePhotonFile(file, [&](ByteSpan bytes) { output->write(bytes.data(), bytes.size()); });
  output->commit();
  context.log.verbose(
      fmt::format("wrote {} photons to '{}'", file.set.photons.size(), files.savephotons));
  return std::move(file.set);
}

void checkPhotonFile(const PhotonFileParams& files, const PhotonNeeds& needs, const Scene& scene,
                     const std::set<std::string>& toBeWritten, Log& log) {
  if (!files.loadphotons.empty() && !toBeWritten.contains(files.loadphotons))
    load(files.loadphotons, needs, scene, log);
}

}  // namespace brume
