// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/bsdf.h"
#include "core/integrator.h"
#include "core/log.h"
#include "core/plan.h"
#include "core/registry.h"
#include "transport/all_lights.h"
#include "transport/final_gather.h"
#include "transport/light_tree.h"
#include "transport/photon_maps.h"
#include "transport/photon_quota.h"
#include "transport/photon_store.h"
#include "transport/specular.h"

namespace brume {
namespace {

/// One of so many photons becomes the site of a radiance photon.
constexpr std::size_t kRadianceShare = 8;

/// Photon mapping: direct light by sampling all lights, caustics by a map of their own, indirect
/// light by final gathering over radiance photons or straight from its map, specular bounces.
///   L = Le + direct + sum_{i nearest} f alpha_i K2(d_i; r_nused) + indirect  [W m^-2 sr^-1]
///   alpha_i photon power [W], K2 kernel [length^-2], r distance to the farthest of nused, which
///   does not count itself, or maxdist
/// Media attenuate light on all of its ways, and scatter into camera rays only: see the volume
/// integrator. Deposit rule: see photon.h. Bias: blur over r (caustics; indirect light without
/// final gathering), glossy surfaces taken as diffuse where gather rays meet them.
/// Sources: Jensen 2001; PBRT-v2. Test: photonmap_test.
class PhotonMap final : public SurfaceIntegrator {
 public:
  struct Params {
    int causticphotons = 20'000;
    int indirectphotons = 100'000;
    int nused = 50;
    int maxspeculardepth = 5;
    int maxphotondepth = 5;
    float maxdist = 0.1f;
    bool finalgather = true;
    int finalgathersamples = 32;
    float gatherangle = 10;
    PhotonFileParams files;

    void visit(ParamVisitor& v) {
      v(causticphotons, "causticphotons", Range<int>{0, kMaxPhotons}, Unit::Photons,
        "photons of the caustic map, about; 0: no caustics");
      v(indirectphotons, "indirectphotons", Range<int>{0, kMaxPhotons}, Unit::Photons,
        "photons of the indirect map, about; 0: no indirect light");
      v(nused, "nused", Range<int>{2, kMaxPhotons}, Unit::Photons,
        "most photons that one lookup uses");
      v(maxspeculardepth, "maxspeculardepth", Range<int>{0, 256}, Unit::None,
        "longest chain of specular bounces; a ray of depth d goes on while d + 1 is below");
      v(maxphotondepth, "maxphotondepth", kPositiveInt, Unit::None,
        "surfaces that a light path visits at most");
      v(maxdist, "maxdist", kPositive, Unit::Length, "no photon farther away than this is used");
      v(finalgather, "finalgather",
        "indirect light by rays to the surroundings instead of straight from its map");
      v(finalgathersamples, "finalgathersamples", Range<int>{1, 1 << 20}, Unit::Samples,
        "rays of one final gathering; half of them follow the BSDF, half the photons");
      v(gatherangle, "gatherangle", Range<float>{0.1f, 180.f}, Unit::Degrees,
        "half-angle of the cones around the photons' directions");
      files.visit(v);
    }
  };

  PhotonMap(Params params, const FactoryContext& context)
      : params_(quickened(std::move(params), context.quick)),
        scene_(*context.scene),
        lights_(emittingLights(scene_), context.sampler) {
    const int half = std::max(1, params_.finalgathersamples / 2);
    gather_.samples = context.sampler ? context.sampler->roundCount(half) : half;
    gather_.cosAngle = std::cos(radians(params_.gatherangle));
    gather_.maxBounces = params_.maxspeculardepth;
  }

  void prepare(PrepareContext& context) override;
  void describe(Plan& plan) const override;
  void checkFiles(const std::set<std::string>& toBeWritten, Log& log) const override {
    checkPhotonFile(params_.files, needs(wantedPhotons()), scene_, toBeWritten, log);
  }
  std::vector<std::string> outputs() const override { return params_.files.outputs(); }
  Rgb Li(const SurfaceQuery& query, RenderContext& context) const override;

 private:
  static constexpr int kMaxPhotons = 1 << 30;

  /// Photons by what they are used for.
  struct Photons {
    std::vector<Photon> direct, caustic, indirect;
    std::vector<Photon> sites;  ///< where radiance photons are to stand
  };
  /// Everything that prepare() makes; the parts refer to each other and stay where they are.
  struct Maps {
    Maps(const Photons& photons, const Accelerator* accelerator)
        : direct(std::span<const Photon>(photons.direct), accelerator),
          caustic(std::span<const Photon>(photons.caustic), accelerator),
          indirect(std::span<const Photon>(photons.indirect), accelerator) {}
    SurfacePhotonMap direct, caustic, indirect;
    std::unique_ptr<RadiancePhotons> radiance;
    std::unique_ptr<FinalGather> gather;
  };

  static Params quickened(Params params, bool isQuick);
  static Photons sortOut(const PhotonSet& set, bool gathers);
  PhotonCounts wantedPhotons() const;
  PhotonNeeds needs(const PhotonCounts& wanted) const;
  PhotonSet tracePhotons(const PhotonCounts& wanted, PrepareContext& context) const;

  Params params_;
  const Scene& scene_;
  AllLights lights_;
  FinalGather::Settings gather_;
  std::unique_ptr<const Maps> maps_;
};

PhotonMap::Params PhotonMap::quickened(Params params, bool isQuick) {
  if (!isQuick) return params;
  params.causticphotons /= 10;
  params.indirectphotons /= 10;
  params.nused = std::max(2, params.nused / 10);
  params.finalgathersamples = std::max(1, params.finalgathersamples / 4);
  return params;
}

/// Final gathering takes every eighth of the direct and indirect photons as sites, and the others,
/// with its power, as light: sites that were chosen by the photons which light them would stand too
/// often where these are dense by chance, and be found too often where they are sparse.
PhotonMap::Photons PhotonMap::sortOut(const PhotonSet& set, bool gathers) {
  Photons sorted;
  std::size_t count = 0;
  for (const Photon& photon : set.photons) {
    if (photon.photonClass() == PhotonClass::SurfaceCaustic) {
      sorted.caustic.push_back(photon);
    } else if (gathers && ++count % kRadianceShare == 0) {
      sorted.sites.push_back(photon);
    } else {
      const bool isDirect = photon.photonClass() == PhotonClass::SurfaceDirect;
      (isDirect ? sorted.direct : sorted.indirect).push_back(photon);
    }
  }
  const float scale = static_cast<float>(kRadianceShare) / (kRadianceShare - 1);
  if (gathers)
    for (auto* photons : {&sorted.direct, &sorted.indirect})
      for (Photon& photon : *photons) photon.power *= scale;
  return sorted;
}

/// Caustics need a specular surface.
PhotonCounts PhotonMap::wantedPhotons() const {
  PhotonCounts wanted{};
  if (takeInventory(scene_).specularMaterials > 0)
    wanted[static_cast<std::size_t>(PhotonClass::SurfaceCaustic)] =
        static_cast<std::uint64_t>(params_.causticphotons);
  wanted[static_cast<std::size_t>(PhotonClass::SurfaceIndirect)] =
      static_cast<std::uint64_t>(params_.indirectphotons);
  return wanted;
}

PhotonSet PhotonMap::tracePhotons(const PhotonCounts& wanted, PrepareContext& context) const {
  PhotonClasses classes;
  for (const PhotonClass c : {PhotonClass::SurfaceCaustic, PhotonClass::SurfaceIndirect})
    if (wanted[static_cast<std::size_t>(c)] > 0) classes = classes | c;
  const bool gathers = params_.finalgather && classes.contains(PhotonClass::SurfaceIndirect);
  PhotonRequest request{gathers ? classes | PhotonClass::SurfaceDirect : classes, context.shutter,
                        params_.maxphotondepth - 1, true};
  const PhotonTracer tracer(scene_, request);
  if (classes.isEmpty() || !tracer.hasLights()) return {};

  const PhotonMapTracing tracing(context);
  PathsPerClass paths = pathsFor(tracer, wanted, classes, context.seed, context.stop, context.stats,
                                 tracing.secondsForPilots());
  for (std::size_t c = 0; c < kPhotonClasses; ++c)
    if (wanted[c] > 0 && paths[c] == 0 && !context.stop)
      context.log.warning(
          {},
          fmt::format("no photons {}: the lights' paths hardly leave any; this light is missing",
                      brume::describe(static_cast<PhotonClass>(c))));
  // Direct light for the gather rays to find, by the same paths.
  if (gathers)
    paths[static_cast<std::size_t>(PhotonClass::SurfaceDirect)] =
        paths[static_cast<std::size_t>(PhotonClass::SurfaceIndirect)];
  return tracing.trace(tracer, paths);
}

void PhotonMap::describe(Plan& plan) const {
  const PhotonCounts wanted = wantedPhotons();
  if (wanted[static_cast<std::size_t>(PhotonClass::SurfaceCaustic)] > 0)
    plan.build("caustic photon map", fmt::format("{} photons", params_.causticphotons));
  else
    plan.skip("caustic photon map",
              params_.causticphotons > 0 ? "no surface is specular" : "\"causticphotons\" is 0");
  if (params_.indirectphotons == 0)
    return plan.skip("indirect photon map", "\"indirectphotons\" is 0");
  plan.build("indirect photon map", fmt::format("{} photons", params_.indirectphotons));
  if (params_.finalgather)
    plan.build("final gathering", fmt::format("{} rays per point", 2 * gather_.samples));
}

PhotonNeeds PhotonMap::needs(const PhotonCounts& wanted) const {
  PhotonNeeds needs;
  if (wanted[static_cast<std::size_t>(PhotonClass::SurfaceIndirect)] > 0) {
    needs.required = PhotonClass::SurfaceIndirect;
    if (params_.finalgather) needs.required = needs.required | PhotonClass::SurfaceDirect;
  }
  if (wanted[static_cast<std::size_t>(PhotonClass::SurfaceCaustic)] > 0)
    needs.optional = PhotonClass::SurfaceCaustic;
  return needs;
}

void PhotonMap::prepare(PrepareContext& context) {
  const PhotonCounts wanted = wantedPhotons();
  const bool gathers =
      wanted[static_cast<std::size_t>(PhotonClass::SurfaceIndirect)] > 0 && params_.finalgather;
  const PhotonSet set = loadOrTracePhotons(params_.files, needs(wanted), scene_, context,
                                           [&] { return tracePhotons(wanted, context); });
  if (!set.isComplete) return;
  if (!set.photons.empty()) warnOfMotion(scene_, context);

  const Photons photons = sortOut(set, gathers);
  auto maps = std::make_unique<Maps>(photons, &scene_.accelerator());
  if (gathers && !maps->indirect.isEmpty()) {
    const SurfacePhotonMap* const all[] = {&maps->direct, &maps->caustic, &maps->indirect};
    const RadianceLookup lookup{static_cast<std::size_t>(params_.nused), params_.maxdist,
                                context.shutter.t0};
    maps->radiance =
        std::make_unique<RadiancePhotons>(scene_, photons.sites, all, lookup, context.stats);
    maps->gather = std::make_unique<FinalGather>(scene_, maps->indirect, *maps->radiance, gather_);
  }
  maps_ = std::move(maps);
}

Rgb PhotonMap::Li(const SurfaceQuery& query, RenderContext& context) const {
  Rgb L = emittedRadiance(query.hit);
  Bsdf bsdf;
  query.hit.material->evaluate(query.hit, bsdf);
  if (!bsdf.isSpecularOnly()) {
    L += lights_.reflected({scene_, query.hit, bsdf, query.media}, context);
    const auto k = static_cast<std::size_t>(params_.nused);
    L += maps_->caustic.radianceOfNearest(query.hit, bsdf, k, params_.maxdist);
    L += maps_->gather ? maps_->gather->reflected(query, bsdf, context)
                       : maps_->indirect.radianceOfNearest(query.hit, bsdf, k, params_.maxdist);
  }
  return L + specularRadiance(query, bsdf, params_.maxspeculardepth, context);
}

const RegisterPlugin<SurfaceIntegrator, PhotonMap> kRegistration{
    "photonmap", Origin::PbrtV2, "photon mapping: caustic and indirect maps, final gathering"};
const RegisterPlugin<SurfaceIntegrator, PhotonMap> kAlias{"exphotonmap", Origin::PbrtV2,
                                                          "another name for \"photonmap\""};

}  // namespace
}  // namespace brume
