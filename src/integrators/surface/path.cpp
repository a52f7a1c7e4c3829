// SPDX-License-Identifier: Apache-2.0
#include "core/bsdf.h"
#include "core/integrator.h"
#include "core/registry.h"
#include "core/sampling.h"
#include "transport/direct_light.h"
#include "transport/even_sky.h"
#include "transport/light_tree.h"
#include "transport/specular.h"

namespace brume {
namespace {

/// Index of the first bounce that roulette may end, as in PBRT-v2.
constexpr int kRouletteBounce = 4;
/// Roulette never ends more than this share of the paths at one bounce.
constexpr float kMinSurvival = 0.05f;

/// Path tracing: all light that reaches the camera over up to maxdepth + 1 surfaces.
///   L = Le + Int f(wo, wi) Li(wi) |cos| dwi, recursively                  [W m^-2 sr^-1]
/// At every vertex one light, chosen by importance, is sampled; the ray that goes on finds light
/// as well, and both are weighted by the power heuristic. An even sky is left to the rays alone.
/// Volumes attenuate every segment (they scatter only into camera rays: see the volume integrator).
/// Emission counts at the camera's vertex, after specular bounces, and as direct light. Unbiased up
/// to maxdepth. Source: Kajiya 1986; Veach 1997. Test: surface_integrators_test.
class Path final : public SurfaceIntegrator {
 public:
  struct Params {
    int maxdepth = 5;
    void visit(ParamVisitor& v) {
      v(maxdepth, "maxdepth", kNonNegativeInt, Unit::None,
        "bounces: paths visit up to maxdepth + 1 surfaces, lit directly at each");
    }
  };
  Path(Params params, const FactoryContext& context)
      : params_(params),
        scene_(*context.scene),
        lights_(lightsToLookAt(scene_), {}),
        leavesEvenSky_(emittingLights(scene_).size() > lights_.lights().size()) {}

  void describe(Plan& plan) const override;
  Rgb Li(const SurfaceQuery& query, RenderContext& context) const override;

 private:
  /// How the last vertex chose the direction of the present ray.
  struct Arrival {
    bool specular = true;  ///< or from the camera
    float bsdfPdf = 0;
    Vec3 from{0};
    PointReceiver receiver{Vec3(0)};
  };
  Rgb emission(const SurfaceInteraction& at, const Arrival& arrival) const;
  Rgb escaped(const Ray& ray, const Arrival& arrival) const;
  Rgb direct(const LitPoint& point, RenderContext& context) const;

  Params params_;
  const Scene& scene_;
  LightTree lights_;
  bool leavesEvenSky_ = false;  ///< to the rays that go on
};

void Path::describe(Plan& plan) const {
  if (leavesEvenSky_) planEvenSky(plan);
}

Rgb Path::emission(const SurfaceInteraction& at, const Arrival& arrival) const {
  if (!at.areaLight) return {};
  const Rgb Le = emittedRadiance(at);
  if (arrival.specular || Le.isBlack()) return Le;
  // A light that is never sampled (inside an object instance) shows itself, but lights nothing.
  const float choice = lights_.probability(arrival.receiver, at.areaLight);
  if (!(choice > 0)) return {};
  const float pdf = choice * at.areaLight->pdfLiAt(arrival.from, -at.wo, at.p, at.n);
  return Le * powerHeuristic(arrival.bsdfPdf, pdf);
}

Rgb Path::escaped(const Ray& ray, const Arrival& arrival) const {
  if (arrival.specular) return escapedRadiance(scene_, ray);
  Rgb L;
  for (const Light* light : scene_.infiniteLights()) {
    const float pdf =
        lights_.probability(arrival.receiver, light) * light->pdfLi(arrival.from, ray.d);
    L += light->Le(ray) * powerHeuristic(arrival.bsdfPdf, pdf);
  }
  return L;
}

Rgb Path::direct(const LitPoint& point, RenderContext& context) const {
  // Dimensions that the scene's lights do not need are not drawn.
  const float uChoice = lights_.lights().size() > 1 ? context.samples.get1D() : 0.f;
  const Vec2 uLight = lights_.hasHittableLights() ? context.samples.get2D() : Vec2(0);
  const auto choice = lights_.choose(PointReceiver(point.at.p, point.at.n), uChoice);
  if (!choice) return {};
  const LitSample lit = sampleLight(point, *choice->light, uLight, kAllLobes, context);
  const float weight = choice->light->isDelta()
                           ? 1.f
                           : powerHeuristic(choice->probability * lit.lightPdf, lit.bsdfPdf);
  return lit.value * (weight / choice->probability);
}

Rgb Path::Li(const SurfaceQuery& query, RenderContext& context) const {
  Rgb L, throughput(1.f);
  Arrival arrival;
  FootprintRay ray = query.ray;
  std::optional<SurfaceInteraction> hit;
  for (int bounce = 0;; ++bounce) {
    const SurfaceInteraction& at = hit ? *hit : query.hit;
    L += throughput * emission(at, arrival);
    if (bounce > params_.maxdepth) break;

    // Light reflected at this vertex.
    context.stats.add(Stat::PathSegments);
    Bsdf bsdf;
    at.material->evaluate(at, bsdf);
    if (!bsdf.isSpecularOnly()) L += throughput * direct({scene_, at, bsdf, query.media}, context);

    // The direction in which the path goes on. The last vertex looks for light that its BSDF can
    // find, and nothing else.
    const float uLobe = context.samples.get1D();
    const Vec2 uDirection = context.samples.get2D();
    const bool isLast = bounce == params_.maxdepth;
    if (isLast && !lights_.hasHittableLights() && !leavesEvenSky_) break;
    const auto sample = bsdf.sample(at.wo, uLobe, uDirection);
    if (!sample || !(sample->pdf > 0) || sample->f.isBlack()) break;
    if (isLast && sample->isSpecular()) break;
    throughput *= sample->f * (absDot(sample->wi, bsdf.shadingNormal()) / sample->pdf);
    arrival = {sample->isSpecular(), sample->pdf, at.p, PointReceiver(at.p, at.n)};

    // Roulette.
    if (bounce >= kRouletteBounce) {
      const float survival = std::clamp(throughput.maxChannel(), kMinSurvival, 1.f);
      if (context.samples.get1D() >= survival) {
        context.stats.add(Stat::RussianRouletteStops);
        break;
      }
      throughput /= survival;
    }

    // The next vertex, attenuated by the media on the way.
    ray = sample->isSpecular() ? specularRay(ray, at, bsdf.shadingNormal(), *sample)
                               : FootprintRay(at.spawnRay(sample->wi));
    hit = scene_.intersect(ray, context.stats);
    if (scene_.volume()) {
      Ray segment = ray;
      if (hit) segment.tMax = distance(ray.o, hit->p);
      throughput *= query.media.transmittance(segment, context);
    }
    if (!hit) {
      L += throughput * escaped(ray, arrival);
      break;
    }
  }
  return L;
}

const RegisterPlugin<SurfaceIntegrator, Path> kRegistration{
    "path", Origin::PbrtV2, "path tracing with multiple importance sampling"};

}  // namespace
}  // namespace brume
