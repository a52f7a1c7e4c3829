// SPDX-License-Identifier: Apache-2.0
#include "core/bsdf.h"
#include "core/integrator.h"
#include "core/medium_along_ray.h"
#include "core/registry.h"
#include "core/sampling.h"
#include "transport/direct_light.h"
#include "transport/distance_sampling.h"
#include "transport/light_choice.h"
#include "transport/light_grid.h"
#include "transport/specular.h"

namespace brume {
namespace {

/// Scatterings after which roulette may end a path whose throughput has fallen.
constexpr int kRouletteStart = 4;
/// Scatterings after which every path meets roulette: without absorption, in a closed scene,
/// nothing else would end it.
constexpr int kLongPath = 100'000;
constexpr float kLongPathSurvival = 0.99f;

/// Volumetric path tracing: all light, over any number of scatterings at surfaces and in media. The
/// judge of the other methods.
///   L(o,w) = Int_0^s Tr(t) [Le(t) + sigma_s(t) Int f_p L(x_t,w') dw'] dt + Tr(s) L_surface
///                                                                         [W m^-2 sr^-1]
/// On every segment the emission of the media and the light of the surface or sky behind are added
/// in full, by their exact attenuation; then one free flight, drawn by inversion of the exact
/// optical depth, decides where the path goes on: in the medium, or at the surface. At every vertex
/// one light is sampled, and the ray that goes on finds light as well; both are weighted by the
/// power heuristic. Lights without extent are moreover seen from an equiangular distance of every
/// segment (Kulla, Fajardo 2012). Chromatic media: the channel that draws the distance is chosen by
/// throughput, and the weight divides by the mean of the channels' densities, so that it stays
/// bounded. Unbiased. What it cannot find: light of a point, spot, distant or projection light that
/// arrives through glass or off a mirror. Source: Novak et al. 2018, Monte Carlo Methods for
/// Volumetric Light Transport Simulation. Test: volpath_test.
class VolPath final : public RayGlobalIntegrator {
 public:
  struct Params {
    std::optional<int> maxdepth;
    void visit(ParamVisitor& v) {
      v(maxdepth, "maxdepth", kNonNegativeInt, Unit::None,
        "most scatterings of a path, at surfaces and in media; unlimited when not given");
    }
  };
  VolPath(Params params, const FactoryContext& context)
      : params_(params), scene_(*context.scene), grid_(scene_), segmentLights_(scene_.lights()) {}

  Rgb Li(const FootprintRay& cameraRay, int depth, RenderContext& context) const override;

 private:
  /// How the last vertex chose the direction of the present ray.
  struct Arrival {
    bool lightIsSampled =
        false;      ///< the vertex sampled the lights as well (not: camera, specular bounce)
    float pdf = 0;  ///< of the direction, per solid angle
    Vec3 from{0};
  };
  struct PathState {
    FootprintRay ray;
    Arrival arrival;
    Rgb L, throughput{1.f};
    int scatterings = 0;
  };

  bool mayScatter(const PathState& path) const {
    return !params_.maxdepth || path.scatterings < *params_.maxdepth;
  }
  Rgb lightBehind(const PathState& path, const std::optional<SurfaceInteraction>& hit) const;
  /// A free flight: where it ends, if in the medium, and with which density [1/length].
  struct Flight {
    std::optional<float> t;
    float pdf = 0;
  };
  /// One segment in the media, and the lights with a position that shine on it.
  struct Segment {
    MediumAlongRay medium;
    Rgb channels;  ///< probability of each channel to draw the distance
    LightChoice::Choices lights;
  };
  static float flightPdf(const Segment& segment, float t);
  static float equiangularPdf(const Segment& segment, const Light& light, float t);
  Rgb equiangularLight(const PathState& path, const Segment& segment, RenderContext& context) const;
  static Flight sampleFlight(PathState& path, const Segment& segment, RenderContext& context);
  Rgb transmittance(const Ray& ray) const;
  bool scatterInMedium(PathState& path, const Segment& segment, const Flight& flight,
                       RenderContext& context) const;
  bool scatterAtSurface(PathState& path, const SurfaceInteraction& at,
                        RenderContext& context) const;
  bool survives(PathState& path, RenderContext& context) const;

  Params params_;
  const Scene& scene_;
  LightGrid grid_;
  LightChoice segmentLights_;
};

/// Emission of the surface that the ray meets, or of the sky, weighted against the sampling of
/// lights at the last vertex.
Rgb VolPath::lightBehind(const PathState& path,
                         const std::optional<SurfaceInteraction>& hit) const {
  const Arrival& from = path.arrival;
  if (hit) {
    const Rgb Le = emittedRadiance(*hit);
    if (Le.isBlack() || !from.lightIsSampled) return Le;
    const float choice = grid_.probability(from.from, hit->areaLight);
    if (!(choice > 0)) return Le;  // a light inside an object instance is never sampled
    return Le * powerHeuristic(from.pdf, choice * hit->areaLight->pdfLiAt(from.from, path.ray.d,
                                                                          hit->p, hit->n));
  }
  Rgb L;
  for (const Light* light : scene_.infiniteLights()) {
    const float lightPdf = from.lightIsSampled ? grid_.probability(from.from, light) *
                                                     light->pdfLi(from.from, path.ray.d)
                                               : 0.f;
    L += light->Le(path.ray) * (lightPdf > 0 ? powerHeuristic(from.pdf, lightPdf) : 1.f);
  }
  return L;
}

Rgb VolPath::transmittance(const Ray& ray) const {
  return scene_.volume() ? scene_.volume()->transmittance(ray) : Rgb(1.f);
}

/// Density of free flights at t: the mean over the channels that may draw them.
float VolPath::flightPdf(const Segment& segment, float t) {
  const Rgb density =
      segment.channels * segment.medium.at(t).sigma_t() * segment.medium.transmittance(t);
  return density.r + density.g + density.b;
}

/// Density with which equiangularLight looks at this light from t, its choice included.
float VolPath::equiangularPdf(const Segment& segment, const Light& light, float t) {
  for (const auto& chosen : segment.lights.all())
    if (chosen.light == &light && t >= chosen.illuminated.t0 && t <= chosen.illuminated.t1)
      return chosen.probability *
             EquiangularSampler(segment.medium.ray(), chosen.illuminated, *light.position()).pdf(t);
  return 0;
}

/// Light of a source with a position, scattered at a distance that is drawn evenly in the angle
/// under which the source sees the segment: like 1 / distance^2, which free flights do not follow,
/// so that alone they have no finite variance around a point light. Weighted by the balance
/// heuristic against the light that is sampled at the end of the free flight.
Rgb VolPath::equiangularLight(const PathState& path, const Segment& segment,
                              RenderContext& context) const {
  const float uChoice = context.samples.get1D(), uDistance = context.samples.get1D();
  if (segment.lights.isEmpty()) return {};
  const auto& chosen = segment.lights.choose(uChoice);
  if (!chosen.light->isDelta() || !chosen.light->position()) return {};
  const DistanceSample at =
      EquiangularSampler(path.ray, chosen.illuminated, *chosen.light->position()).sample(uDistance);
  const MediumCoefficients medium = segment.medium.at(at.t);
  if (!(at.pdf > 0) || medium.sigma_s.isBlack()) return {};

  context.stats.add(Stat::VolumeSamples);
  const Vec3 p = path.ray(at.t);
  const auto light = chosen.light->sampleLi(p, Vec2(.5f));
  if (!light || light->L.isBlack()) return {};
  const Ray shadow = Scene::shadowRay(p, path.ray.time, *light);
  if (scene_.isOccluded(shadow, context.stats)) return {};
  const Rgb phase = scene_.volume()->phase(p, -path.ray.d, light->wi);
  const float pdf =
      chosen.probability * at.pdf + grid_.probability(p, chosen.light) * flightPdf(segment, at.t);
  return path.throughput * segment.medium.transmittance(at.t) * medium.sigma_s * light->L *
         transmittance(shadow) * phase / pdf;
}

/// Draws a free flight; the throughput takes the attenuation, sigma_s and the density in.
VolPath::Flight VolPath::sampleFlight(PathState& path, const Segment& segment,
                                      RenderContext& context) {
  const Rgb& channels = segment.channels;
  const float uChannel = context.samples.get1D(), uDepth = context.samples.get1D();
  const int channel = uChannel < channels.r                                   ? 0
                      : uChannel < channels.r + channels.g || channels.b == 0 ? 1
                                                                              : 2;
  // What chose the channel refines the depth as well: 24 bits alone would draw depths below 1e-6 by
  // the wrong probability.
  const double before = channel == 0 ? 0 : channel == 1 ? channels.r : channels.r + channels.g;
  const double rest =
      std::clamp((uChannel - before) / double{channels[channel]}, 0.0, double{kOneMinusEpsilon});
  Flight flight;
  flight.t = segment.medium.invert(channel, -std::log1p(-(double{uDepth} + rest * 0x1p-24)));
  if (!flight.t) {
    const Rgb Tr = segment.medium.transmittance(), reach = channels * Tr;
    path.throughput *= Tr / (reach.r + reach.g + reach.b);
    return flight;
  }
  flight.pdf = flightPdf(segment, *flight.t);
  path.throughput = flight.pdf > 0 ? path.throughput * segment.medium.transmittance(*flight.t) *
                                         segment.medium.at(*flight.t).sigma_s / flight.pdf
                                   : Rgb();
  return flight;
}

/// Light sampled at a point in the medium, then a direction of the phase function. False: the path
/// ends.
bool VolPath::scatterInMedium(PathState& path, const Segment& segment, const Flight& flight,
                              RenderContext& context) const {
  const Volume& volume = *scene_.volume();
  const Vec3 p = path.ray(*flight.t), wo = -path.ray.d;
  context.stats.add(Stat::VolumeSamples);

  // Next-event estimation: one light, chosen for this point.
  const float uChoice = context.samples.get1D();
  const Vec2 uLight = context.samples.get2D();
  if (const auto choice = grid_.choose(p, uChoice)) {
    if (const auto light = choice->light->sampleLi(p, uLight);
        light && light->pdf > 0 && !light->L.isBlack()) {
      const Rgb phase = volume.phase(p, wo, light->wi);
      const Ray shadow = Scene::shadowRay(p, path.ray.time, *light);
      if (!phase.isBlack() && !scene_.isOccluded(shadow, context.stats)) {
        const float lightPdf = choice->probability * light->pdf;
        // Lights without extent are also seen by equiangularLight, the others by the ray that goes
        // on.
        float weight = powerHeuristic(lightPdf, phasePdf(phase, path.throughput));
        if (choice->light->isDelta()) {
          const float here = choice->probability * flight.pdf;
          const float there =
              choice->light->position() ? equiangularPdf(segment, *choice->light, *flight.t) : 0.f;
          weight = here / (here + there);
        }
        path.L += path.throughput * transmittance(shadow) * light->L * phase * (weight / lightPdf);
      }
    }
  }

  const float uLobe = context.samples.get1D();
  const ScatterSample sample =
      volume.samplePhase(p, wo, path.throughput, uLobe, context.samples.get2D());
  if (!(sample.pdf > 0)) return false;
  path.throughput *= sample.value / sample.pdf;
  path.ray = FootprintRay(Ray{p, sample.wi, kInfinity, path.ray.time});
  path.arrival = {true, sample.pdf, p};
  return true;
}

/// Light sampled at a surface point, then a direction of the BSDF. False: the path ends.
bool VolPath::scatterAtSurface(PathState& path, const SurfaceInteraction& at,
                               RenderContext& context) const {
  Bsdf bsdf;
  at.material->evaluate(at, bsdf);

  // Next-event estimation, for what is not specular.
  if (!bsdf.isSpecularOnly()) {
    const float uChoice = context.samples.get1D();
    const Vec2 uLight = context.samples.get2D();
    if (const auto choice = grid_.choose(at.p, uChoice)) {
      if (const auto light = choice->light->sampleLi(at.p, uLight);
          light && light->pdf > 0 && !light->L.isBlack()) {
        const BsdfValue value = bsdf.evaluate(at.wo, light->wi);
        const Ray shadow = Scene::shadowRay(at, *light);
        if (!value.f.isBlack() && !scene_.isOccluded(shadow, context.stats)) {
          const float lightPdf = choice->probability * light->pdf,
                      cosine = absDot(light->wi, bsdf.shadingNormal());
          const float weight = choice->light->isDelta() ? 1.f : powerHeuristic(lightPdf, value.pdf);
          path.L += path.throughput * transmittance(shadow) * light->L * value.f *
                    (cosine * weight / lightPdf);
        }
      }
    }
  }

  const float uLobe = context.samples.get1D();
  const auto sample = bsdf.sample(at.wo, uLobe, context.samples.get2D());
  if (!sample || !(sample->pdf > 0)) return false;
  path.throughput *= sample->f * (absDot(sample->wi, bsdf.shadingNormal()) / sample->pdf);
  path.ray = sample->isSpecular() ? specularRay(path.ray, at, bsdf.shadingNormal(), *sample)
                                  : FootprintRay(at.spawnRay(sample->wi));
  path.arrival = {!sample->isSpecular(), sample->pdf, at.p};
  return true;
}

/// Russian roulette. By the throughput alone, so that a path that has lost nothing goes on: in a
/// medium that absorbs nothing survival is 1, until the path is so long that only a closed scene
/// can hold it.
bool VolPath::survives(PathState& path, RenderContext& context) const {
  const float carried = path.throughput.maxChannel();
  if (!(carried > 0)) return false;
  if (path.scatterings < kRouletteStart) return true;
  const float survival = std::min(carried, path.scatterings < kLongPath ? 1.f : kLongPathSurvival);
  if (survival >= 1.f) return true;
  if (context.samples.get1D() >= survival) {
    context.stats.add(Stat::RussianRouletteStops);
    return false;
  }
  path.throughput /= survival;
  return true;
}

Rgb VolPath::Li(const FootprintRay& cameraRay, int, RenderContext& context) const {
  PathState path;
  path.ray = cameraRay;
  thread_local Segment segment;  // reused, so that its memory is
  for (;;) {
    const auto hit = scene_.intersect(path.ray, context.stats);
    context.stats.add(Stat::PathSegments);
    if (hit) path.ray.tMax = distance(path.ray.o, hit->p);

    // What the segment itself and its end shine, exactly attenuated.
    const auto range = scene_.volume() ? scene_.volume()->intersect(path.ray) : std::nullopt;
    Rgb behind = lightBehind(path, hit);
    if (range) {
      segment.medium.assign(*scene_.volume(), path.ray, *range);
      behind *= segment.medium.transmittance();
      if (scene_.volume()->isEmissive()) path.L += path.throughput * segment.medium.emission();
      context.stats.add(Stat::VolumeSegments);
    }
    path.L += path.throughput * behind;
    if (!mayScatter(path)) break;

    // Where the path goes on.
    Flight flight;
    if (range) {
      const Rgb& carried = path.throughput;
      segment.channels = carried / (carried.r + carried.g + carried.b);
      if (scene_.volume()->isScattering() && !segment.medium.isEmpty()) {
        segmentLights_.along(path.ray, *range, segment.lights);
        path.L += equiangularLight(path, segment, context);
      }
      flight = sampleFlight(path, segment, context);
    }
    if (!flight.t && !hit) break;
    ++path.scatterings;
    if (path.throughput.isBlack()) break;
    const bool goesOn = flight.t ? scatterInMedium(path, segment, flight, context)
                                 : scatterAtSurface(path, *hit, context);
    if (!goesOn) break;
    if (!survives(path, context)) break;
  }
  return path.L;
}

const RegisterPlugin<GlobalIntegrator, VolPath> kRegistration{
    "volpath", Origin::Brume,
    "unbiased volumetric path tracing: all light at surfaces and in media"};

}  // namespace
}  // namespace brume
