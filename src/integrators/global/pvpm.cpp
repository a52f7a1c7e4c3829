// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>

#include "accelerators/beam_quadtree.h"
#include "accelerators/beam_raster.h"
#include "core/camera.h"
#include "core/film.h"
#include "core/log.h"
#include "core/lowdiscrepancy.h"
#include "core/medium_along_ray.h"
#include "core/plan.h"
#include "core/registry.h"
#include "transport/beam_radiance.h"
#include "transport/blur_monitor.h"
#include "transport/camera_beams.h"
#include "transport/first_radius.h"
#include "transport/pass_balance.h"
#include "transport/photon_maps.h"
#include "transport/photon_store.h"
#include "transport/photon_tracer.h"
#include "transport/radius_schedule.h"
#include "transport/surface_photon_map.h"

namespace brume {
namespace {

enum class Lookup { Quadtree, Raster, Linear };
enum class Schedule { Global, Beam };

constexpr std::uint64_t kFirstLookAtBlur = 64;  // passes

Rgb toRgb(const BeamSum& sum) {
  return {static_cast<float>(sum.r), static_cast<float>(sum.g), static_cast<float>(sum.b)};
}

/// Progressive volume photon mapping: pass after pass, every camera ray is a beam that gathers the
/// photons inside it, photons are forgotten, and the radii shrink.
///   Lv(o,w) ~= 1/n sum_{j=1}^n sum_{i: d_i < r_j} Tr(0,t_i) albedo(x_i) f_p alpha_i K2(d_i; r_j)
///                                                                          [W m^-2 sr^-1]
///   t_i distance of photon i's foot along the beam, d_i its distance from it, alpha_i power [W],
///   K2 kernel [length^-2], f_p phase function [sr^-1]; radii shrink by a RadiusSchedule, or each
///   pixel's by its own count of photons (CountedRadius)
/// Surfaces: direct light by sampling; caustics and indirect light by the photons of the pass
/// around the visible point, with a radius of the same schedule. Beams go on through mirrors and
/// glass. Unscattered light in media is sampled (directvolume), or left to photons. Deposit rule:
/// at every collision, before the albedo (applied to the photons of a pass, nowhere else). Bias
/// O(r^2) and variance O(1/r^2) per pass; both vanish with the number of passes. Memory: beams and
/// photons of one pass; photons that were loaded serve in every pass, and then only the beams are
/// new. Sources: Hachisuka, Ogaki, Jensen 2008; Knaus, Zwicker 2011; Jarosz, Zwicker, Jensen 2008.
/// Test: pvpm_test.
class Pvpm final : public PassGlobalIntegrator {
 public:
  struct Params {
    int passes = 64;
    std::optional<int> photonsperpass;
    std::optional<float> radius, surfaceradius;
    Schedule schedule = Schedule::Global;
    float alpha = 2.f / 3;
    Lookup lookup = Lookup::Quadtree;
    bool fixedbeams = false;
    bool directvolume = true;
    int maxbounces = 16;
    std::optional<int> maxdepth;
    PhotonFileParams files;

    void visit(ParamVisitor& v) {
      v(passes, "passes", kPositiveInt, Unit::None,
        "passes, when neither --passes nor --time nor --error says");
      v(photonsperpass, "photonsperpass", Range<int>{1, 1 << 30}, Unit::None,
        "light paths of a pass; by default as many as take about as long as its camera paths, "
        "200000 for savephotons");
      v(radius, "radius", kPositive, Unit::Length,
        "of the beams in the first pass; by default in balance of noise and blur");
      v(surfaceradius, "surfaceradius", kPositive, Unit::Length,
        "on surfaces in the first pass; by default in balance of noise and blur");
      v(schedule, "schedule", {{"global", Schedule::Global}, {"beam", Schedule::Beam}},
        "global: all radii shrink alike, r'^2 = r^2 (j + alpha) / (j + 1) after pass j; beam: each "
        "pixel's by its own photons, r'^2 = r^2 (N + alpha M) / (N + M)");
      v(alpha, "alpha", Range<float>{0.01f, 1.f}, Unit::None,
        "how slowly radii shrink; 1: not at all");
      v(lookup, "lookup",
        {{"quadtree", Lookup::Quadtree}, {"raster", Lookup::Raster}, {"linear", Lookup::Linear}},
        "how photons find their beams; the image does not depend on it. raster: by projection, for "
        "the beams of a pinhole, the quadtree for all others");
      v(fixedbeams, "fixedbeams", "beams through the pixels' centres instead of jittered ones");
      v(directvolume, "directvolume",
        "sample unscattered light in media instead of leaving it to photons");
      v(maxbounces, "maxbounces", Range<int>{0, 1000}, Unit::None,
        "most specular bounces of a camera path");
      v(maxdepth, "maxdepth", kNonNegativeInt, Unit::None,
        "most scatterings of a light path; unlimited when not given");
      files.visit(v);
    }
  };

  Pvpm(Params params, const FactoryContext& context)
      : params_(params),
        quick_(context.quick),
        pathsPerPass_(params.photonsperpass.value_or(200'000)),
        scene_(*context.scene),
        wanted_(showableClasses(scene_, {1, 1, !params.directvolume, {}})),
        paths_(scene_, {params.maxbounces, true, params.directvolume}) {
    if (params.fixedbeams && scene_.volume() && scene_.volume()->isTracked())
      throw SceneError(
          context.where,
          "\"fixedbeams\" would see the same tentative collisions of a tracked medium in "
          "every pass: leave it off");
  }

  void checkFiles(const std::set<std::string>& toBeWritten, Log& log) const override {
    checkPhotonFile(params_.files, {{}, wanted_}, scene_, toBeWritten, log);
  }
  std::vector<std::string> outputs() const override { return params_.files.outputs(); }
  void prepare(PrepareContext& context) override {
    tracer_ = std::make_unique<PhotonTracer>(
        scene_, PhotonRequest{wanted_, context.shutter, params_.maxdepth});
    if (!tracer_->hasLights()) wanted_ = {};
    shutter_ = context.shutter;
    keepPhotons(context);
  }
  void describe(Plan& plan) const override;
  void describeView(Plan& plan, const Camera& camera, const Film& film) const override;
  std::int64_t defaultPasses() const override {
    return quick_ ? std::max(1, params_.passes / 4) : params_.passes;
  }
  bool renderPass(const PassContext& context,
                  const std::function<void(double share)>& onShare) override;
  double squaredBlur() const override;

 private:
  void keepPhotons(const PrepareContext& context);
  void choosePathsAndRadii(const PassContext& context);
  void learnShares(const PassContext& context, const PhotonSet& pilot, const FirstRadii& radii);
  std::optional<float> momentOf(const PassContext& context);
  void prepareRadii(const PassContext& context, CameraBeamOptions& options);
  void watchBlur(const PassContext& context, const CameraBeams& camera,
                 const CameraBeamOptions& options);
  void shrinkPixelRadii(const OwnedBeams& beams, std::span<const BeamSum> sums);
  PhotonSet tracePhotons(std::uint64_t seed, std::uint64_t pass, std::int64_t paths,
                         const std::atomic<bool>& stop, Stats& stats, PhotonSet old = {}) const;
  void gather(const OwnedBeams& beams, const VolumePhotons& photons, const Bounds2i* image,
              CameraBeams& to, Stats& stats);
  std::unique_ptr<BeamLookup> makeLookup(const OwnedBeams& beams, const Bounds2i* image) const;

  Params params_;
  bool quick_;  // --quick: a quarter of the passes
  std::int64_t pathsPerPass_;
  const Scene& scene_;
  PhotonClasses wanted_;
  CameraPaths paths_;
  std::unique_ptr<PhotonTracer> tracer_;
  std::optional<std::vector<float>> shares_;  // of paths by their sources
  Interval shutter_;
  std::optional<PhotonSet> kept_;  // loaded: the same for every pass
  std::optional<RadiusSchedule> beamRadius_, surfaceRadius_;
  std::optional<BlurMonitor> monitor_;
  std::vector<CountedRadius> countedRadii_;  // of each pixel, schedule "beam"
  std::vector<float> pixelRadii_;            // their present values
  // Of the present pass; members for their memory.
  PhotonSet traced_;
  CameraBeams camera_;
  VolumePhotons inMedium_;
  std::vector<BeamSum> sums_;
};

void Pvpm::describe(Plan& plan) const {
  if ((wanted_ & kVolumePhotons).isEmpty())
    plan.skip("camera beams and photons in media", "no medium scatters");
  else
    plan.build("camera beams and photons in media",
               params_.directvolume ? "unscattered light is sampled, photons carry the rest"
                                    : "photons carry all scattered light");
  if ((wanted_ & kSurfacePhotons).isEmpty())
    plan.skip("visible points and photons on surfaces", "nothing in the scene is diffuse");
  else
    plan.build("visible points and photons on surfaces",
               "caustics and indirect light; direct light is sampled");
  planSkippedPhotons(scene_, plan);
}

/// How many beams a pass has, from a grid of pixels.
void Pvpm::describeView(Plan& plan, const Camera& camera, const Film& film) const {
  if ((wanted_ & kVolumePhotons).isEmpty()) return;
  constexpr int kMostPerAxis = 64;
  const Bounds2i pixels = film.sampleBounds();
  const int nx = std::min(kMostPerAxis, pixels.width()),
            ny = std::min(kMostPerAxis, pixels.height());
  Stats stats;
  std::int64_t seeing = 0;
  for (int y = 0; y < ny; ++y)
    for (int x = 0; x < nx; ++x) {
      CameraSample sample;
      sample.raster = Vec2(Vec2d(pixels.lo) + Vec2d((x + 0.5) / nx, (y + 0.5) / ny) *
                                                  Vec2d(pixels.width(), pixels.height()));
      sample.lens = Vec2(0.5f);
      FootprintRay ray(camera.generateRay(sample));
      if (const auto hit = scene_.intersect(ray, stats)) ray.tMax = distance(ray.o, hit->p);
      const auto range = scene_.volume()->intersect(ray);
      seeing += range && !MediumAlongRay(*scene_.volume(), ray, *range).isEmpty();
    }
  const double share = static_cast<double>(seeing) / (nx * ny);
  plan.build("one beam for each pixel that sees a medium",
             fmt::format("about {:.0f} of {} pixels, each pass; mirrors and glass add theirs",
                         share * static_cast<double>(pixels.area()), pixels.area()));
}

PhotonSet Pvpm::tracePhotons(std::uint64_t seed, std::uint64_t pass, std::int64_t count,
                             const std::atomic<bool>& stop, Stats& stats, PhotonSet old) const {
  PathsPerClass paths{};
  for (std::size_t c = 0; c < kPhotonClasses; ++c)
    if (wanted_.contains(static_cast<PhotonClass>(c))) paths[c] = static_cast<std::uint64_t>(count);
  return tracer_->trace(seed, pass, paths, stop, stats, std::move(old));
}

/// Photons from a file, or into one.
void Pvpm::keepPhotons(const PrepareContext& context) {
  const PhotonFileParams& files = params_.files;
  if (files.loadphotons.empty() && files.savephotons.empty()) return;
  PhotonSet photons = loadOrTracePhotons(files, {{}, wanted_}, scene_, context, [&] {
    return tracePhotons(context.seed, 0, pathsPerPass_, context.stop, context.stats);
  });
  if (!files.loadphotons.empty() && photons.isComplete) kept_ = std::move(photons);
}

/// The number of light paths and the radii that were not given, from a pilot pass of photons with
/// random numbers of its own.
void Pvpm::choosePathsAndRadii(const PassContext& context) {
  constexpr std::uint64_t kPilotPass = ~std::uint64_t{0};
  constexpr int kPilotPaths = 20'000;
  const bool beams = !(wanted_ & kVolumePhotons).isEmpty(),
             points = !(wanted_ & kSurfacePhotons).isEmpty();
  const bool needsRadii = (beams && !params_.radius) || (points && !params_.surfaceradius),
             needsPaths = (beams || points) && !kept_ && !params_.photonsperpass;
  PhotonSet pilot;
  PassCost pass;
  if (kept_) {
    pass.paths = static_cast<double>(*std::max_element(kept_->paths.begin(), kept_->paths.end()));
  } else if (needsRadii || needsPaths) {
    Stats stats;
    pilot = tracePhotons(context.seed, kPilotPass, kPilotPaths, context.stop, stats);
    if (!pilot.isComplete) return;
    const double perPath = 1. / kPilotPaths;
    const LightPathMean mean{perPath * static_cast<double>(stats[Stat::PhotonSegments]),
                             perPath * static_cast<double>(pilot.photons.size())};
    if (needsPaths) {
      pathsPerPass_ = balancedPaths(context.film.sampleBounds().area(), mean);
      context.log.verbose(fmt::format("pvpm: {} light paths a pass", pathsPerPass_));
    }
    pass.paths = static_cast<double>(pathsPerPass_);
    pass.segments = mean.segments * pass.paths;
    context.stats.merge(stats);
  }
  FirstRadii radii;
  if (needsRadii) {
    radii = firstRadii(scene_, paths_, context, kept_ ? *kept_ : pilot, pass);
    if (!kept_) learnShares(context, pilot, radii);
  }
  if (beams) {
    if (params_.radius) radii.beam = double{*params_.radius};
    beamRadius_.emplace(radii.beam, params_.alpha);
    context.log.verbose(fmt::format("pvpm: the beams' first radius is {:.4g}", radii.beam));
  }
  if (points) {
    if (params_.surfaceradius) radii.surface = double{*params_.surfaceradius};
    surfaceRadius_.emplace(radii.surface, params_.alpha);
    context.log.verbose(fmt::format("pvpm: the first radius on surfaces is {:.4g}", radii.surface));
  }
}

/// Light paths start where photons come from that are received and make noise. With photons of
/// power P [W], where N of a kind with equal P would make a variance V of the image, a path's part
/// is
///   c^2 = sum over kinds of V / <sum P^2> sum over its photons P^2
void Pvpm::learnShares(const PassContext& context, const PhotonSet& pilot,
                       const FirstRadii& radii) {
  constexpr std::uint64_t kSharesPass = ~std::uint64_t{1};
  constexpr std::uint64_t kSharesPaths = 20'000;
  const auto squareOf = [&radii](const Photon& photon) -> double {
    const Bounds3& reach = photon.isOnSurface() ? radii.surfaceReach : radii.beamReach;
    return reach.contains(photon.p) ? sqr(double{largestChannel(photon.power)}) : 0;
  };
  double onSurfaces = 0, inMedia = 0;  // sum P^2 of the pilot
  for (const Photon& photon : pilot.photons)
    (photon.isOnSurface() ? onSurfaces : inMedia) += squareOf(photon);
  const double perSurfaceSquare = onSurfaces > 0 ? radii.surfaceVariance / onSurfaces : 0,
               perMediumSquare = inMedia > 0 ? radii.beamVariance / inMedia : 0;
  if (!(perSurfaceSquare + perMediumSquare > 0)) return;
  const auto square = [&](std::span<const Photon> photons) {
    double sum = 0;
    for (const Photon& photon : photons)
      sum += (photon.isOnSurface() ? perSurfaceSquare : perMediumSquare) * squareOf(photon);
    return sum;
  };
  Stats stats;
  shares_ =
      tracer_->learnShares(context.seed, kSharesPass, kSharesPaths, square, context.stop, stats);
  context.stats.merge(stats);
  if (shares_) tracer_->setShares(*shares_);
}

/// `image`: beams straight from the camera; none: beams from anywhere.
std::unique_ptr<BeamLookup> Pvpm::makeLookup(const OwnedBeams& beams, const Bounds2i* image) const {
  if (params_.lookup == Lookup::Linear) return std::make_unique<LinearBeams>(beams.beams);
  if (params_.lookup == Lookup::Raster && image && RasterBeams::suits(beams.beams))
    return std::make_unique<RasterBeams>(beams.beams);
  if (image)
    return std::make_unique<BeamQuadtree>(beams.beams, Vec2i(image->width(), image->height()));
  return std::make_unique<BeamQuadtree>(BeamQuadtree::inSpace(beams.beams));
}

/// Adds the radiance that the beams gather to their samples.
void Pvpm::gather(const OwnedBeams& beams, const VolumePhotons& photons, const Bounds2i* image,
                  CameraBeams& to, Stats& stats) {
  if (beams.beams.empty()) return;
  sums_ =
      gatherBeams(*scene_.volume(), beams, *makeLookup(beams, image), photons, std::move(sums_));
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    const BeamOwner& owner = beams.owners[i];
    stats.add(Stat::PhotonBeamPairs, sums_[i].count);
    to.samples[owner.sample].L += owner.weight * stats.checkRadiance(toRgb(sums_[i]));
  }
  shrinkPixelRadii(beams, sums_);
}

/// Sets the radii of a pass; those of the global schedule go on to the next one.
void Pvpm::prepareRadii(const PassContext& context, CameraBeamOptions& options) {
  if (surfaceRadius_) {
    options.surfaceRadius = static_cast<float>(std::sqrt(surfaceRadius_->radius2()));
    surfaceRadius_->advance();
  }
  if (!beamRadius_) return;
  if (params_.schedule == Schedule::Global) {
    options.beamRadius = static_cast<float>(std::sqrt(beamRadius_->radius2()));
    beamRadius_->advance();
    return;
  }
  if (countedRadii_.empty()) {
    const auto pixels = static_cast<std::size_t>(context.film.sampleBounds().area());
    countedRadii_.assign(pixels, CountedRadius(std::sqrt(beamRadius_->radius2())));
    pixelRadii_.resize(pixels);
  }
  for (std::size_t i = 0; i < pixelRadii_.size(); ++i)
    pixelRadii_[i] = static_cast<float>(std::sqrt(countedRadii_[i].radius2()));
  options.pixelRadii = pixelRadii_;
}

void Pvpm::shrinkPixelRadii(const OwnedBeams& beams, std::span<const BeamSum> sums) {
  if (params_.schedule != Schedule::Beam) return;
  for (std::size_t i = 0; i < sums.size(); ++i)
    countedRadii_[beams.beams[i].pixel].shrink(static_cast<double>(sums[i].count),
                                               double{params_.alpha});
}

/// The blur of each kind of photons that stands out of its noise.
double Pvpm::squaredBlur() const {
  double sum = 0;
  for (const auto kind : {BlurMonitor::Beams, BlurMonitor::Surfaces})
    if (const auto found = monitor_ ? monitor_->estimate(kind) : std::nullopt;
        found && found->standsOut())
      sum += found->blur2;
  return sum;
}

/// Tells the monitor of a pass. Radii that nobody gave and that turn out to blur more than they
/// should, because the pilot could not see what is blurred, shrink at once, and the more passes,
/// the better is that known.
void Pvpm::watchBlur(const PassContext& context, const CameraBeams& camera,
                     const CameraBeamOptions& options) {
  if (!monitor_) return;
  monitor_->addPass(probeLight(camera),
                    {sqr(double{options.beamRadius}), sqr(double{options.surfaceRadius})});
  const auto passes = static_cast<std::uint64_t>(context.pass) + 1;
  if (passes < kFirstLookAtBlur || !std::has_single_bit(passes)) return;
  const auto sharpen = [&](BlurMonitor::Kind kind, std::optional<RadiusSchedule>& schedule,
                           bool given, std::string_view what) {
    if (!schedule || given) return;
    const auto found = monitor_->estimate(kind);
    const double factor = found ? found->radiusFactor() : 1;
    if (factor == 1) return;
    schedule->scale(factor);
    context.log.verbose(fmt::format("pvpm: after {} passes the radius {} is {:.4g}", passes, what,
                                    std::sqrt(schedule->radius2())));
  };
  sharpen(BlurMonitor::Beams, beamRadius_, params_.radius.has_value(), "of beams");
  sharpen(BlurMonitor::Surfaces, surfaceRadius_, params_.surfaceradius.has_value(), "on surfaces");
}

/// The time of a pass in a scene that moves, as part of the shutter's: photons and beams of one
/// pass must see the same scene. Evenly spread over the passes.
std::optional<float> Pvpm::momentOf(const PassContext& context) {
  if (!scene_.isMoving()) return std::nullopt;
  const float u = shiftedRadicalInverse(2, static_cast<std::uint32_t>(context.pass),
                                        static_cast<std::uint32_t>(hashIntegers(context.seed)));
  const float time = lerp(shutter_.t0, shutter_.t1, u);
  tracer_ = std::make_unique<PhotonTracer>(scene_,
                                           PhotonRequest{wanted_, {time, time}, params_.maxdepth});
  if (shares_) tracer_->setShares(*shares_);
  return u;
}

bool Pvpm::renderPass(const PassContext& context, const std::function<void(double)>& onShare) {
  if (context.pass == 0) choosePathsAndRadii(context);
  const std::optional<float> moment = momentOf(context);
  // Photons first, so that visible points gather them at once and need not be kept.
  if (!kept_) {
    traced_ = tracePhotons(context.seed, static_cast<std::uint64_t>(context.pass), pathsPerPass_,
                           context.stop, context.stats, std::move(traced_));
    if (!traced_.isComplete) return false;
  }
  const std::vector<Photon>& photons = kept_ ? kept_->photons : traced_.photons;
  onShare(0.3);

  CameraBeamOptions options;
  if (context.pass == 0 && !kept_ && params_.schedule == Schedule::Global)
    monitor_.emplace(context.film.sampleBounds());
  options.monitor = monitor_ ? &*monitor_ : nullptr;
  options.moment = moment;
  options.wantsBeams = beamRadius_.has_value();
  options.throughCentres = params_.fixedbeams;
  std::optional<SurfacePhotonMap> surface;
  if (surfaceRadius_) {
    surface.emplace(std::span<const Photon>(photons), &scene_.accelerator());
    options.surface = &*surface;
  }
  prepareRadii(context, options);
  camera_ = traceCameraBeams(context, paths_, options, std::move(camera_));
  if (camera_.samples.empty()) return false;
  onShare(0.6);

  if (beamRadius_) {
    Bounds3 reach = reachOf(camera_.primary.beams);
    reach.extend(reachOf(camera_.secondary.beams));
    const float largest = options.pixelRadii.empty() ? options.beamRadius
                                                     : *std::max_element(options.pixelRadii.begin(),
                                                                         options.pixelRadii.end());
    inMedium_.assign(*scene_.volume(), photons, {reach, largest});
    if (context.pass == 0 && inMedium_.outsideCount() > 0)
      context.log.verbose(fmt::format("pvpm: {} photons of the first pass lie outside of all beams",
                                      inMedium_.outsideCount()));
    gather(camera_.primary, inMedium_, &camera_.pixels, camera_, context.stats);
    gather(camera_.secondary, inMedium_, nullptr, camera_, context.stats);
    if (context.stop.load(std::memory_order_relaxed)) return false;
  }
  watchBlur(context, camera_, options);
  addToFilm(camera_, context.film);
  return true;
}

const RegisterPlugin<GlobalIntegrator, Pvpm> kRegistration{
    "pvpm", Origin::Brume,
    "progressive volume photon mapping: any number of photons in constant memory"};

}  // namespace
}  // namespace brume
