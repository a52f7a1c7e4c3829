// SPDX-License-Identifier: Apache-2.0
// The three kinds of integrator (DESIGN.md 4). Per camera ray: L = Li_surface Tr + Lv.
#pragma once

#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/camera.h"
#include "core/film.h"
#include "core/params.h"
#include "core/path_component.h"
#include "core/ray.h"
#include "core/sampler.h"
#include "core/scene.h"
#include "core/stats.h"

namespace brume {

struct Plan;

/// What one thread changes while it renders.
struct RenderContext {
  SampleStream& samples;
  Stats& stats;
  /// Where radiance goes by the kind of its path, beside what is returned; null when nobody asked.
  ComponentRadiance* components = nullptr;
};

/// The image to come.
struct ImageView {
  const Camera& camera;
  const Sampler& sampler;
  Bounds2i pixels;
};

/// What an integrator may use before the first camera ray, to trace photons and build maps.
struct PrepareContext {
  std::uint64_t seed = 0;
  Interval shutter{0, 1};         ///< times at which the scene is seen
  const std::atomic<bool>& stop;  ///< set: leave off as soon as possible; no ray will be asked for
  Stats& stats;
  Log& log;
  const ImageView* view = nullptr;  ///< null where nobody knows
  /// What tracing photons had better not take longer than (--time); fewer are traced then.
  double secondsForPhotons = HUGE_VAL;
  /// Is told what is done, and how much of it; from any thread. May be empty.
  std::function<void(std::string_view what, double share)> onShare = {};
};

/// What an integrator is made from, beside its parameters. The scene outlives it.
struct IntegratorFactoryContext {
  const Scene* scene = nullptr;
  const Sampler* sampler = nullptr;  ///< for rounding sample counts
  bool quick = false;
  SourceLocation where;
  Log* log = nullptr;
};

/// In-scattered and emitted radiance along a ray through the media, and what is left of the light
/// behind.
struct VolumeRadiance {
  Rgb Lv;       ///< [W m^-2 sr^-1]
  Rgb Tr{1.f};  ///< transmittance of the whole segment
};

class VolumeIntegrator {
 public:
  static constexpr std::string_view kPluginKind = "VolumeIntegrator";
  using FactoryContext = IntegratorFactoryContext;
  virtual ~VolumeIntegrator() = default;
  /// Adds what is built for this scene, what is left out and what cannot be found, and why.
  virtual void describe(Plan&) const {}
  /// Along (0, ray.tMax); tMax may be infinite.
  virtual VolumeRadiance integrate(const Ray& ray, RenderContext& context) const = 0;
  /// Tr alone: shadow rays and path segments.
  virtual Rgb transmittance(const Ray& ray, RenderContext& context) const = 0;
};

/// What surface and global integrators share: their work before the first ray.
class PreparedIntegrator {
 public:
  virtual ~PreparedIntegrator() = default;
  /// Called once, before the first ray or pass. Throws SceneError when the scene gives no ground to
  /// stand on.
  virtual void prepare(PrepareContext&) {}
  /// Adds what is built for this scene, what is left out and what cannot be found, and why.
  virtual void describe(Plan&) const {}
  /// Reads the files that prepare() would use, and warns and throws SceneError as it would; but not
  /// those that are still to be written.
  virtual void checkFiles(const std::set<std::string>& toBeWritten, Log&) const {
    static_cast<void>(toBeWritten);
  }
  /// The files that prepare() writes.
  virtual std::vector<std::string> outputs() const { return {}; }
};

/// Radiance along a ray, surfaces and media together. Surface integrators call it for specular
/// bounces, the tile renderer for camera rays; per-ray global integrators implement it.
class RayRadiance {
 public:
  virtual ~RayRadiance() = default;
  /// depth counts specular bounces so far, 0 for camera rays.
  virtual Rgb Li(const FootprintRay& ray, int depth, RenderContext& context) const = 0;
  /// Whether Li fills RenderContext::components.
  virtual bool splitsComponents() const { return false; }
};

/// The parts of the scene that a surface integrator works with.
struct SurfaceQuery {
  const FootprintRay& ray;
  const SurfaceInteraction& hit;
  int depth = 0;
  const RayRadiance& radiance;    ///< for specular bounces
  const VolumeIntegrator& media;  ///< for transmittance
};

class SurfaceIntegrator : public PreparedIntegrator {
 public:
  static constexpr std::string_view kPluginKind = "SurfaceIntegrator";
  using FactoryContext = IntegratorFactoryContext;
  /// Radiance leaving the hit towards the ray's origin, before attenuation on the way.
  virtual Rgb Li(const SurfaceQuery& query, RenderContext& context) const = 0;
};

/// Replaces surface and volume integrator and owns the image loop. Those that answer per ray derive
/// from RayGlobalIntegrator.
class GlobalIntegrator : public PreparedIntegrator {
 public:
  static constexpr std::string_view kPluginKind = "GlobalIntegrator";
  using FactoryContext = IntegratorFactoryContext;
};

/// A global integrator that answers per camera ray: the tile renderer runs it.
class RayGlobalIntegrator : public GlobalIntegrator, public RayRadiance {};

/// What one pass of a PassGlobalIntegrator works with; everything outlives the pass.
struct PassContext {
  const Camera& camera;
  const Sampler& sampler;
  Film& film;
  std::uint64_t seed = 0;
  std::int64_t pass = 0;   ///< from 0
  bool footprints = true;  ///< whether any texture will look at the rays' differentials
  const std::atomic<bool>& stop;
  Stats& stats;
  Log& log;
};

/// A global integrator that answers per pass: each pass adds one estimate of every pixel to the
/// film, so that the image, its variance and the limits of a render are those of the film.
class PassGlobalIntegrator : public GlobalIntegrator {
 public:
  /// Adds what the camera sees to the plan.
  virtual void describeView(Plan&, const Camera&, const Film&) const {}
  /// Passes when nothing else limits the render.
  virtual std::int64_t defaultPasses() const = 0;
  /// Called with pass = 0, 1, ... in order. Returns false, with nothing added to the film, when
  /// `stop` was set meanwhile. `onShare` is told the share of the pass that is done.
  virtual bool renderPass(const PassContext& context,
                          const std::function<void(double share)>& onShare) = 0;
  /// Squared relative error of the mean of all passes that another pass would repeat, as far as the
  /// passes tell: the film's variance cannot see it.
  virtual double squaredBlur() const { return 0; }
};

}  // namespace brume
