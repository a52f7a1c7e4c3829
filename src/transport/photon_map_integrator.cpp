// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_map_integrator.h"

#include <fmt/format.h>

#include "core/plan.h"
#include "transport/photon_mirror.h"

namespace brume {
namespace {

/// Of the scene's diagonal: how far the photons of a surface point are looked for.
constexpr float kSurfaceReach = 0.1f;

}  // namespace

PhotonMapIntegrator::PhotonMapIntegrator(const PhotonMapParams& params,
                                         VolumePhotonMap::Power power,
                                         const FactoryContext& context)
    : params_(params),
      power_(power),
      scene_(*context.scene),
      paths_(scene_, {params.maxbounces, true, params.directvolume}),
      surfaceReach_(kSurfaceReach * 2 * scene_.bounds().radius()) {}

namespace {

/// The largest distance to the k-th neighbour among some photons.
float largestReach(const PhotonKdTree& tree, std::size_t k) {
  constexpr std::size_t kAsked = 256;
  std::vector<Neighbour> found(k);
  float reach2 = 0;
  for (std::size_t i = 0; i < tree.size(); i += tree.size() / kAsked + 1)
    if (tree.nearest(tree.point(i), found) == k)
      reach2 = std::max(reach2, found.front().distance2());
  return std::sqrt(reach2);
}

}  // namespace

PhotonMapRequest PhotonMapIntegrator::request() const {
  PhotonMapRequest request;
  request.volumePhotons = static_cast<std::uint64_t>(params_.photons);
  request.surfacePhotons = static_cast<std::uint64_t>(params_.surfacephotons);
  request.unscatteredVolume = !params_.directvolume;
  request.maxDepth = params_.maxdepth;
  return request;
}

PhotonNeeds PhotonMapIntegrator::needs(PhotonClasses wanted) {
  return {wanted & (PhotonClass::VolumeUnscattered | PhotonClass::VolumeMultiple), wanted};
}

void PhotonMapIntegrator::describe(Plan& plan) const {
  const PhotonClasses wanted = showableClasses(scene_, request());
  const bool isLoaded = !params_.files.loadphotons.empty();
  const auto describeMap = [&](const char* what, PhotonClasses classes, int photons,
                               const char* reason) {
    if (!(wanted & classes).isEmpty())
      plan.build(what, isLoaded ? fmt::format("from '{}'", params_.files.loadphotons)
                                : fmt::format("about {} of them", photons));
    else
      plan.skip(what, photons > 0 ? reason : "none are asked for");
  };
  describeMap("map of photons in media", kVolumePhotons, params_.photons, "no medium scatters");
  describeMap("map of photons on surfaces", kSurfacePhotons, params_.surfacephotons,
              "nothing in the scene is diffuse");
  planSkippedPhotons(scene_, plan);
}

void PhotonMapIntegrator::prepare(PrepareContext& context) {
  const PhotonMapRequest request = this->request();
  const PhotonClasses wanted = showableClasses(scene_, request);
  const PhotonSet set = loadOrTracePhotons(params_.files, needs(wanted), scene_, context,
                                           [&] { return tracePhotons(scene_, request, context); });
  if (!set.isComplete) return;

  if (!(wanted & kSurfacePhotons).isEmpty()) {
    surfaceMap_.emplace(std::span<const Photon>(set.photons), &scene_.accelerator());
    if (surfaceMap_->isEmpty()) surfaceMap_.reset();
    if (surfaceMap_) warnOfMotion(scene_, context);
  }
  if (!(wanted & kVolumePhotons).isEmpty()) {
    volumeMap_.emplace(*scene_.volume(), set.photons, power_, params_.radius.value_or(0));
    if (!params_.radius && power_ == VolumePhotonMap::Power::Scattered &&
        !PhotonMirror(*scene_.volume()).isEmpty()) {
      // How far images must reach is known from the map without them.
      const float reach = largestReach(volumeMap_->tree(), static_cast<std::size_t>(params_.nused));
      volumeMap_.emplace(*scene_.volume(), set.photons, power_, reach);
    }
    if (volumeMap_->size() > 0) onVolumeMap(*volumeMap_);
  }
}

/// Adds what photons say about the stretches and points that a camera path meets.
struct PhotonMapIntegrator::Visitor final : CameraPathVisitor {
  Visitor(const PhotonMapIntegrator& self_, RenderContext& context_)
      : self(self_), context(context_) {}

  void onSegment(const MediumAlongRay& medium, const Rgb& weight, int) override {
    if (!self.volumeMap_ || self.volumeMap_->size() == 0) return;
    const BeamEstimate estimate = self.estimate(*self.volumeMap_, medium, context);
    context.stats.add(Stat::PhotonBeamPairs, estimate.photons);
    L += weight * context.stats.checkRadiance(estimate.L);
  }
  void onSurface(const SurfaceInteraction& at, const Bsdf& bsdf, const Rgb& weight) override {
    if (!self.surfaceMap_) return;
    const auto k = static_cast<std::size_t>(self.params_.nusedsurface);
    const Rgb found = self.surfaceMap_->radianceOfNearest(at, bsdf, k, self.surfaceReach_);
    L += weight * context.stats.checkRadiance(found);
  }

  const PhotonMapIntegrator& self;
  RenderContext& context;
  Rgb L;
};

Rgb PhotonMapIntegrator::Li(const FootprintRay& ray, int, RenderContext& context) const {
  Visitor visitor(*this, context);
  const Rgb L = paths_.follow(ray, visitor, context);
  return L + visitor.L;
}

}  // namespace brume
