// SPDX-License-Identifier: Apache-2.0
// What "vpm" and "bre" share: all but the estimate along a stretch of medium.
#pragma once

#include "transport/camera_path.h"
#include "transport/photon_estimates.h"
#include "transport/photon_maps.h"
#include "transport/photon_store.h"

namespace brume {

/// Parameters of both.
struct PhotonMapParams {
  int photons = 200'000, surfacephotons = 200'000;
  int nused = 50, nusedsurface = 100;
  std::optional<float> radius;
  bool directvolume = true;
  int maxbounces = 16;
  std::optional<int> maxdepth;
  PhotonFileParams files;

  void visit(ParamVisitor& v) {
    constexpr Range<int> kPhotons{0, 1 << 30}, kUsed{2, 1 << 20};
    v(photons, "photons", kPhotons, Unit::None, "photons to store in media, about");
    v(surfacephotons, "surfacephotons", kPhotons, Unit::None,
      "photons to store on surfaces, about");
    v(nused, "nused", kUsed, Unit::None,
      "nearest photons that set the radius in media, where radius is not given");
    v(nusedsurface, "nusedsurface", kUsed, Unit::None, "nearest photons used on surfaces");
    v(radius, "radius", kPositive, Unit::Length, "of all lookups in media");
    v(directvolume, "directvolume",
      "sample unscattered light in media instead of leaving it to photons");
    v(maxbounces, "maxbounces", Range<int>{0, 1000}, Unit::None,
      "most specular bounces of a camera path");
    v(maxdepth, "maxdepth", kNonNegativeInt, Unit::None,
      "most scatterings of a light path; unlimited when not given");
    files.visit(v);
  }
};

/// One set of photons, then an answer per camera ray. Surfaces: direct light by sampling, caustics
/// and indirect light by the nearest photons. Rays go on through mirrors and glass. Unscattered
/// light in media is sampled, or left to photons. Caustics and multiply scattered light in media:
/// by what derives from this.
class PhotonMapIntegrator : public RayGlobalIntegrator {
 public:
  void prepare(PrepareContext& context) final;
  void describe(Plan& plan) const final;
  void checkFiles(const std::set<std::string>& toBeWritten, Log& log) const final {
    checkPhotonFile(params_.files, needs(showableClasses(scene_, request())), scene_, toBeWritten,
                    log);
  }
  std::vector<std::string> outputs() const final { return params_.files.outputs(); }
  Rgb Li(const FootprintRay& ray, int depth, RenderContext& context) const final;

 protected:
  /// `power`: what the volume photons are to carry.
  PhotonMapIntegrator(const PhotonMapParams& params, VolumePhotonMap::Power power,
                      const FactoryContext& context);
  const Scene& scene() const { return scene_; }

 private:
  /// Called once with the photons in the media, at least one.
  virtual void onVolumeMap(const VolumePhotonMap& map) = 0;
  /// Light that photons scatter towards the start of a medium's range; after onVolumeMap.
  virtual BeamEstimate estimate(const VolumePhotonMap& map, const MediumAlongRay& medium,
                                RenderContext& context) const = 0;

  PhotonMapRequest request() const;
  static PhotonNeeds needs(PhotonClasses wanted);
  struct Visitor;

  PhotonMapParams params_;
  VolumePhotonMap::Power power_;
  const Scene& scene_;
  CameraPaths paths_;
  float surfaceReach_;
  std::optional<VolumePhotonMap> volumeMap_;
  std::optional<SurfacePhotonMap> surfaceMap_;
};

}  // namespace brume
