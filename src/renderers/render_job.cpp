// SPDX-License-Identifier: Apache-2.0
#include "renderers/render_job.h"

#include <fmt/format.h>

#include <chrono>
#include <mutex>

#include "core/camera.h"
#include "core/compatibility.h"
#include "core/log.h"
#include "core/plan.h"
#include "core/version.h"
#include "renderers/camera_radiance.h"
#include "renderers/overrides.h"
#include "renderers/pass_loop.h"
#include "renderers/pass_renderer.h"
#include "renderers/plugin_factory.h"
#include "renderers/tile_renderer.h"

namespace brume {

/// Everything a frame needs, in the order in which it is made.
struct RenderJob::Parts {
  Parts(SceneDescription description, const RenderSettings& settings, Log& log);
  void makeImageSide(RenderOptions& options, PluginFactory& factory, Log& log);
  void makeIntegrators(RenderOptions& options, PluginFactory& factory);
  void checkLayers() const;
  RenderLimits limits() const;
  template <class Work>
  void withIntegrator(Work&& work) const;
  std::unique_ptr<ImageRenderer> makeRenderer() const;
  RenderResult resultAt(const RenderOutcome& outcome, const Stats& stats) const;
  std::vector<std::string> planLines() const;
  const DeferredFiles* deferredFiles() const;
  DeferredCounts files() const;

  RenderSettings settings;
  Log& log;
  std::unique_ptr<Filter> filter;
  std::unique_ptr<Film> film;
  std::unique_ptr<Camera> camera;
  std::unique_ptr<Sampler> sampler;
  std::unique_ptr<Scene> scene;
  Plan plan;

  ClearMedia clearMedia;
  std::unique_ptr<SurfaceIntegrator> surface;
  std::unique_ptr<VolumeIntegrator> media;
  std::unique_ptr<GlobalIntegrator> global;
  SourceLocation integratorAt;  // the directive of the one or the other
  std::unique_ptr<CameraRadiance> joined;
  // How the image is made: per ray (joined, or the global integrator), or per pass.
  const RayRadiance* radiance = nullptr;
  PassGlobalIntegrator* passes = nullptr;

  std::vector<UsedPlugin> plugins;
  double setupSeconds = 0;
  bool isRendered = false;
};

namespace {

/// Of --time, that photon maps may take.
constexpr double kPhotonShare = 0.5;

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Shows what is done before the first pass; may be told of it by many threads.
class PrepareProgress {
 public:
  explicit PrepareProgress(const std::function<void(const RenderProgress&)>& progress)
      : progress_(progress) {}
  void show(std::string_view what, double share) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || !progress_) return;
    const double now = secondsSince(start_);
    if (now < nextReport_) return;
    nextReport_ = now + kSecondsBetweenReports;
    RenderProgress p;
    p.what = what;
    p.fraction = share;
    p.seconds = now;
    progress_(p);
  }

 private:
  const std::function<void(const RenderProgress&)>& progress_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double nextReport_ = kSecondsBetweenReports;
};

/// The camera's motion in render space, whose origin is at sceneOrigin.
AnimatedTransform cameraInRenderSpace(const RenderOptions& options, const Vec3d& sceneOrigin) {
  const Transform shift = Transform::translate(-sceneOrigin);
  const AnimatedTransform& camera = options.cameraToWorld;
  if (!camera.isAnimated()) return AnimatedTransform(shift * camera.start());
  return {shift * camera.start(), camera.startTime(), shift * camera.end(), camera.endTime()};
}

void checkSettings(const RenderSettings& settings) {
  if (settings.samplesPerPixel && *settings.samplesPerPixel < 1)
    throw SceneError("--spp must be at least 1");
  if (settings.passes && *settings.passes < 1) throw SceneError("--passes must be at least 1");
  if (settings.maxSeconds && !(*settings.maxSeconds > 0))
    throw SceneError("--time must be greater than 0");
  if (settings.targetError && !(*settings.targetError > 0))
    throw SceneError("--error must be greater than 0");
}

}  // namespace

RenderJob::Parts::Parts(SceneDescription description, const RenderSettings& settings_, Log& log_)
    : settings(settings_), log(log_) {
  const auto begin = std::chrono::steady_clock::now();
  checkSettings(settings);
  RenderOptions& options = description.options;
  overrideIntegrators(settings.integrators, options, log);
  refuseUnbuilt(options, !settings.integrators.empty(), log);

  PluginFactory factory(options.searchDirectory, log);
  factory.make<RendererChoice>(options.renderer, {});
  factory.make<AcceleratorChoice>(options.accelerator, {});
  log.verboseOnce(fmt::format("Accelerator \"{}\": Embree is used, as for every scene",
                              options.accelerator.name));
  const Vec3d origin = description.world.sceneOrigin;
  options.cameraToWorld = cameraInRenderSpace(options, origin);
  makeImageSide(options, factory, log);

  const IdleParts idle = dropIdle(description.world);
  scene = std::make_unique<Scene>(std::move(description.world));
  plan = planScene(takeInventory(*scene));
  planIdle(description.unused, idle, plan);
  makeIntegrators(options, factory);
  checkLayers();
  for (const std::string& line : planLines()) log.verbose("plan: " + line);
  plugins = factory.takeUsed();
  setupSeconds = secondsSince(begin);
}

void RenderJob::Parts::makeImageSide(RenderOptions& options, PluginFactory& factory, Log&) {
  filter = factory.make<Filter>(options.filter, {});

  Film::FactoryContext filmContext;
  filmContext.filter = filter.get();
  filmContext.outputName = settings.outputName;
  filmContext.resolution = settings.resolution;
  filmContext.crop = settings.crop;
  filmContext.quick = settings.quick;
  filmContext.variance = settings.variance;
  filmContext.needsVariance = settings.targetError.has_value();
  filmContext.layers = settings.layers;
  film = factory.make<Film>(options.film, filmContext);

  Camera::FactoryContext cameraContext;
  cameraContext.cameraToWorld = options.cameraToWorld;
  cameraContext.resolution = film->resolution();
  camera = factory.make<Camera>(options.camera, cameraContext);

  Sampler::FactoryContext samplerContext;
  samplerContext.pixels = film->sampleBounds();
  samplerContext.quick = settings.quick;
  samplerContext.samplesPerPixel = settings.samplesPerPixel;
  sampler = factory.make<Sampler>(options.sampler, samplerContext);
}

void RenderJob::Parts::makeIntegrators(RenderOptions& options, PluginFactory& factory) {
  IntegratorFactoryContext context;
  context.scene = scene.get();
  context.sampler = sampler.get();
  context.quick = settings.quick;
  integratorAt = options.globalIntegrator ? options.globalIntegrator->params.where()
                                          : options.surfaceIntegrator.params.where();

  if (options.globalIntegrator) {
    global = factory.make<GlobalIntegrator>(*options.globalIntegrator, context);
    radiance = dynamic_cast<const RayGlobalIntegrator*>(global.get());
    passes = dynamic_cast<PassGlobalIntegrator*>(global.get());
    BRUME_CHECK(radiance != nullptr || passes != nullptr);
    plan.build(fmt::format("global integrator \"{}\"", options.globalIntegrator->name),
               "it replaces surface and volume integrator");
    global->describe(plan);
    if (passes) passes->describeView(plan, *camera, *film);
    return;
  }

  surface = factory.make<SurfaceIntegrator>(options.surfaceIntegrator, context);
  plan.build(fmt::format("surface integrator \"{}\"", options.surfaceIntegrator.name));
  surface->describe(plan);
  // The volume integrator is made even when it is skipped, so that its parameters are checked.
  media = factory.make<VolumeIntegrator>(options.volumeIntegrator, context);
  const std::string what = fmt::format("volume integrator \"{}\"", options.volumeIntegrator.name);
  if (scene->volume()) {
    plan.build(what);
    media->describe(plan);
  } else {
    plan.skip(what, "the scene has no Volume");
  }
  const VolumeIntegrator& used = scene->volume() ? *media : clearMedia;
  joined = std::make_unique<CameraRadiance>(*scene, *surface, used);
  radiance = joined.get();
}

/// Says which layers cannot be had.
void RenderJob::Parts::checkLayers() const {
  if (!film->settings().withLayers) return;
  if (passes)
    throw SceneError(
        "layers are written by integrators that answer per ray; this one renders "
        "whole passes");
  if (!radiance->splitsComponents())
    log.warning({},
                "the layers of light are left out: \"volpath\" alone tells its parts apart; "
                "depth, normal, albedo and transmittance are written");
}

RenderJob::RenderJob(SceneDescription description, const RenderSettings& settings, Log& log)
    : parts_(std::make_unique<Parts>(std::move(description), settings, log)) {}

RenderJob::~RenderJob() = default;

RenderLimits RenderJob::Parts::limits() const {
  RenderLimits limits;
  if (!passes) {
    limits.round = sampler->samplesPerPixel();
    limits.wholeRounds = sampler->isAdaptive();
  }
  limits.maxSeconds = settings.maxSeconds;
  limits.targetError = settings.targetError;
  // A pass is one sample of every pixel: --spp counts passes there.
  if (passes && settings.samplesPerPixel)
    limits.rounds = std::int64_t{*settings.samplesPerPixel} * settings.passes.value_or(1);
  else if (settings.passes)
    limits.rounds = *settings.passes;
  else if (!limits.maxSeconds && !limits.targetError)
    limits.rounds = passes ? passes->defaultPasses() : 1;
  return limits;
}

RenderResult RenderJob::Parts::resultAt(const RenderOutcome& outcome, const Stats& stats) const {
  RenderResult result;
  result.stats = stats;
  result.reason = outcome.reason;
  result.seconds = outcome.seconds;
  result.setupSeconds = setupSeconds;
  result.samples = outcome.samples;
  result.estimatedError = outcome.estimatedError;
  result.passes = static_cast<int>(outcome.samples / limits().round);
  result.image = film->develop();

  // What is needed to repeat the run.
  auto& metadata = result.image.metadata;
  metadata["brume:version"] = version();
  metadata["brume:seed"] = fmt::format("{}", settings.seed);
  metadata["brume:passes"] = fmt::format("{}", result.passes);
  metadata["brume:samples per pixel"] = fmt::format("{}", outcome.samples);
  metadata["brume:seconds"] = fmt::format("{:.3f}", outcome.seconds);
  for (const UsedPlugin& plugin : plugins) {
    std::string text = fmt::format("\"{}\"", plugin.name);
    for (const ParamRecord& record : plugin.params)
      if (record.type != "alias")
        text += fmt::format(" \"{} {}\" [{}]", record.type, record.name, record.value);
    metadata["brume:" + plugin.kind] = text;
  }
  std::string planText;
  for (const std::string& line : planLines()) planText += line + "\n";
  metadata["brume:plan"] = planText;
  return result;
}

const DeferredFiles* RenderJob::Parts::deferredFiles() const {
  FileCache* files = scene->contents().files.get();
  return files ? &DeferredFiles::of(*files) : nullptr;
}

DeferredCounts RenderJob::Parts::files() const {
  const DeferredFiles* files = deferredFiles();
  return files ? files->count() : DeferredCounts{};
}

/// The plan, and what has become of the files.
std::vector<std::string> RenderJob::Parts::planLines() const {
  Plan all = plan;
  planFiles(files(), isRendered, all);
  return all.lines();
}

/// Errors that know no place, of photon files say, are given that of the integrator.
template <class Work>
void RenderJob::Parts::withIntegrator(Work&& work) const {
  try {
    if (global) work(*global);
    if (surface) work(*surface);
  } catch (const SceneError& error) {
    if (error.where().isKnown()) throw;
    throw SceneError(integratorAt, error.what());
  }
}

std::unique_ptr<ImageRenderer> RenderJob::Parts::makeRenderer() const {
  const Scene::Contents& contents = scene->contents();
  const bool footprints = !contents.floatTextures.empty() || !contents.rgbTextures.empty();
  if (passes)
    return std::make_unique<PassRenderer>(
        PassRenderer::Parts{*camera, *sampler, *film, *passes, settings.seed, footprints, log});
  return std::make_unique<TileRenderer>(
      TileRenderParts{*camera, *sampler, *film, *radiance, settings.seed, footprints, scene.get()});
}

RenderResult RenderJob::run(const std::atomic<bool>& stop,
                            const std::function<void(const RenderProgress&)>& progress,
                            const std::function<void(const RenderResult&)>& snapshot,
                            const std::function<void(const RenderResult&)>& rescue) {
  parts_->isRendered = true;
  const Parts& p = *parts_;
  const std::unique_ptr<ImageRenderer> renderer = p.makeRenderer();
  RenderLimits limits = p.limits();
  Stats stats;
  const auto start = std::chrono::steady_clock::now();
  // All of the image, so that crop windows of it have the same photons and fit together.
  const ImageView view{*p.camera, *p.sampler, {Vec2i(0), p.film->resolution()}};
  PrepareContext prepare{p.settings.seed, p.camera->shutter(), stop, stats, p.log, &view};
  if (limits.maxSeconds) prepare.secondsForPhotons = kPhotonShare * *limits.maxSeconds;
  PrepareProgress prepareProgress(progress);
  prepare.onShare = [&](std::string_view what, double share) { prepareProgress.show(what, share); };
  p.withIntegrator([&](PreparedIntegrator& integrator) { integrator.prepare(prepare); });
  limits.secondsSpent = secondsSince(start);

  RenderWatch watch{progress, {}, {}};
  if (snapshot)
    watch.snapshot = [&](const RenderOutcome& soFar) { snapshot(p.resultAt(soFar, stats)); };
  if (rescue) watch.rescue = [&](const RenderOutcome& soFar) { rescue(p.resultAt(soFar, stats)); };
  return p.resultAt(renderPortions(*renderer, *p.film, limits, stop, stats, watch), stats);
}

bool RenderJob::isProgressive() const { return parts_->passes != nullptr; }
const Film& RenderJob::film() const { return *parts_->film; }
const Scene& RenderJob::scene() const { return *parts_->scene; }
const std::vector<RenderJob::UsedPlugin>& RenderJob::plugins() const { return parts_->plugins; }
std::vector<std::string> RenderJob::plan() const { return parts_->planLines(); }
DeferredCounts RenderJob::files() const { return parts_->files(); }
void RenderJob::readAllFiles(const std::set<std::string>& toBeWritten) const {
  if (const DeferredFiles* files = parts_->deferredFiles()) files->loadAll();
  parts_->withIntegrator([&](const PreparedIntegrator& integrator) {
    integrator.checkFiles(toBeWritten, parts_->log);
  });
}
std::vector<std::string> RenderJob::outputs() const {
  std::vector<std::string> all;
  parts_->withIntegrator([&](const PreparedIntegrator& integrator) {
    std::ranges::copy(integrator.outputs(), std::back_inserter(all));
  });
  return all;
}

}  // namespace brume
