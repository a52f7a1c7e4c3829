// SPDX-License-Identifier: Apache-2.0
#include "core/bsdf.h"
#include "core/integrator.h"
#include "core/medium_along_ray.h"
#include "core/plan.h"
#include "core/registry.h"
#include "core/sampling.h"
#include "transport/direct_light.h"
#include "transport/emission_sampling.h"
#include "transport/even_sky.h"
#include "transport/light_tree.h"
#include "transport/segment_lights.h"
#include "transport/specular.h"
#include "transport/towards_lights.h"

namespace brume {
namespace {

/// Paths that carry less than this share of what they began with, and looks at lights of which less
/// is scattered into the path, may end by roulette; those that go on carry this much then.
constexpr float kRouletteBelow = 1 / 3.f;
/// Random numbers of 24 bits do not hit smaller probabilities well.
constexpr float kLeastSurvival = 1e-4f;
/// Scatterings after which every path meets roulette: without absorption, in a closed scene,
/// nothing else would end it.
constexpr int kLongPath = 100'000;
constexpr float kLongPathSurvival = 0.99f;

/// One segment of a path in the media, with the probability of each channel to draw the distance.
struct Segment {
  MediumAlongRay medium;
  Rgb channels;
  SegmentLights::Chances lights;
  bool looksAtLights = false;  ///< some segments do: SegmentLights::mayHelp

  /// Density of free flights at t [1/length]: the mean over the channels that may draw them.
  float flightPdf(double t) const {
    const Rgb density =
        channels * medium.at(static_cast<float>(t)).sigma_t() * medium.transmittance(t);
    return density.r + density.g + density.b;
  }
};

/// A direction in which a path goes on.
struct Outgoing {
  FootprintRay ray;
  Rgb weight;     ///< scattering function times cosine [1/sr], or the whole weight if specular
  float pdf = 0;  ///< per solid angle
  bool isSpecular = false;
  float aimed = 1;  ///< pdf over that of the scattering function alone
};

/// A collision in a medium, as a vertex of a path: scatters by the phase function.
class MediumVertex {
 public:
  static constexpr Scattering kScattering = Scattering::Medium;
  /// `carried`: the path's throughput, sigma_s included.
  MediumVertex(const Scene& scene, const Ray& ray, float t, const Rgb& carried)
      : volume_(*scene.volume()), p_(ray(t)), wo_(-ray.d), carried_(carried), time_(ray.time) {}

  const Vec3& p() const { return p_; }
  PointReceiver receiver() const { return PointReceiver(p_); }
  bool seesLights() const { return true; }
  Ray spawn(const Vec3& wi) const { return {p_, wi, kInfinity, time_}; }
  Ray shadowRay(const LightSample& light) const { return Scene::shadowRay(p_, time_, light); }
  BsdfValue evaluate(const Vec3& wi) const {
    const Rgb phase = volume_.phase(p_, wo_, wi);
    return {phase, phasePdf(phase, carried_)};
  }
  std::optional<Outgoing> sample(const FootprintRay&, float uLobe, Vec2 u) const {
    const ScatterSample s = volume_.samplePhase(p_, wo_, carried_, uLobe, u);
    return Outgoing{FootprintRay(spawn(s.wi)), s.value, s.pdf};
  }

 private:
  const Volume& volume_;
  Vec3 p_, wo_;
  Rgb carried_;
  float time_;
};

/// A point on a surface, as a vertex of a path: scatters by the BSDF.
class SurfaceVertex {
 public:
  static constexpr Scattering kScattering = Scattering::Surface;
  explicit SurfaceVertex(const SurfaceInteraction& at) : at_(at) {
    at.material->evaluate(at, bsdf_);
  }

  const Vec3& p() const { return at_.p; }
  PointReceiver receiver() const { return {at_.p, at_.n}; }
  bool seesLights() const { return !bsdf_.isSpecularOnly(); }
  Ray spawn(const Vec3& wi) const { return at_.spawnRay(wi); }
  Ray shadowRay(const LightSample& light) const { return Scene::shadowRay(at_, light); }
  BsdfValue evaluate(const Vec3& wi) const {
    BsdfValue value = bsdf_.evaluate(at_.wo, wi);
    value.f *= absDot(wi, bsdf_.shadingNormal());
    return value;
  }
  std::optional<Outgoing> sample(const FootprintRay& arriving, float uLobe, Vec2 u) const {
    const auto s = bsdf_.sample(at_.wo, uLobe, u);
    if (!s) return std::nullopt;
    const Rgb f = s->f * absDot(s->wi, bsdf_.shadingNormal());
    if (!s->isSpecular()) return Outgoing{FootprintRay(spawn(s->wi)), f, s->pdf};
    return Outgoing{specularRay(arriving, at_, bsdf_.shadingNormal(), *s), f, s->pdf, true};
  }

 private:
  const SurfaceInteraction& at_;
  Bsdf bsdf_;
};

/// Volumetric path tracing: all light, over any number of scatterings at surfaces and in media. The
/// judge of the other methods.
///   L(o,w) = Int_0^s Tr(t) [Le(t) + sigma_s(t) Int f_p L(x_t,w') dw'] dt + Tr(s) L_surface
///                                                                         [W m^-2 sr^-1]
/// On every segment the emission of the media and the light of the surface or sky behind are added
/// in full, by their exact attenuation; then one free flight, drawn by inversion of the exact
/// optical depth, decides where the path goes on: in the medium, or at the surface. At every vertex
/// one light is sampled, emitting media among them, and the ray that goes on finds light as well;
/// both are weighted by the power heuristic. Small lights are moreover seen from an equiangular
/// distance of every segment (Kulla, Fajardo 2012), and some directions are drawn
/// around those inside media, so that their surroundings have finite variance. Chromatic media: the
/// channel that draws the distance is chosen by throughput, and the weight divides by the mean of
/// the channels' densities, so that it stays bounded. Emitting media are looked at from where they
/// fill few of the directions, small lights from segments that flights seldom end on near them, and
/// skies unless they are about even: elsewhere the path finds them by itself. Unbiased. What it
/// cannot find: light of a point, spot, distant or projection light that arrives through glass or
/// off a mirror. Source: Novak et al. 2018, Monte Carlo Methods for Volumetric Light Transport
/// Simulation. Test: volpath_test.
class VolPath final : public RayGlobalIntegrator {
 public:
  enum class LightsBy { Tree, Even };
  enum class FoundBy { Both, Looking, Hitting };
  struct Params {
    std::optional<int> maxdepth;
    LightsBy lights = LightsBy::Tree;
    FoundBy lightfoundby = FoundBy::Both;
    bool equiangular = true, towardslights = true, emissionsampling = true, roulette = true;
    void visit(ParamVisitor& v) {
      v(maxdepth, "maxdepth", kNonNegativeInt, Unit::None,
        "most scatterings of a path, at surfaces and in media; unlimited when not given");
      v(lights, "lights", {{"tree", LightsBy::Tree}, {"even", LightsBy::Even}},
        "how the light that a vertex looks at is chosen: by what it sends there, or evenly");
      v(lightfoundby, "lightfoundby",
        {{"both", FoundBy::Both}, {"looking", FoundBy::Looking}, {"hitting", FoundBy::Hitting}},
        "how light that scatters is found: by looking at lights and by rays that hit them, both "
        "weighted, or by one of them alone");
      v(equiangular, "equiangular",
        "look at small lights from a distance of every segment drawn by angle");
      v(towardslights, "towardslights", "draw some directions around point lights in media");
      v(emissionsampling, "emissionsampling", "look at emitting media as at lights");
      v(roulette, "roulette", "end paths and looks at lights at random that carry little");
    }
  };
  VolPath(Params params, const FactoryContext& context);

  Rgb Li(const FootprintRay& cameraRay, int depth, RenderContext& context) const override;
  bool splitsComponents() const override { return true; }
  void describe(Plan& plan) const override;

 private:
  /// How the last vertex chose the direction of the present ray.
  struct Arrival {
    /// The lights that the vertex looks at; null: at none (camera, specular bounce).
    const LightTree* lights = nullptr;
    float pdf = 0;  ///< of the direction, per solid angle
    Vec3 from{0};
    PointReceiver receiver{Vec3(0)};
  };
  struct PathState {
    FootprintRay ray;
    Arrival arrival;
    Rgb L, throughput{1.f};
    int scatterings = 0;
    float aimed = 1;  ///< of the present direction: see Outgoing
    /// What it carried after its first scattering that was not specular; 0 before that.
    float usual = 0;
    PathComponent component = PathComponent::Emission;  ///< of light that the present ray meets
  };
  /// A free flight: where it ends, if in the medium, and with which density [1/length].
  struct Flight {
    std::optional<float> t;
    float pdf = 0;
  };
  using Towards = TowardsLights::Directions;

  static double evenShare(const Params& params) {
    return params.lights == LightsBy::Even ? 1 : 0.1;
  }
  static void addLight(PathState& path, PathComponent component, const Rgb& L,
                       RenderContext& context) {
    path.L += L;
    if (context.components) context.components->add(component, L);
  }
  /// Weights of light that is found by looking at it and by a ray that hits it, from the densities
  /// of both per solid angle.
  float lookingWeight(float looking, float hitting) const {
    return params_.lightfoundby == FoundBy::Both ? powerHeuristic(looking, hitting) : 1.f;
  }
  float hittingWeight(float hitting, float looking) const {
    switch (params_.lightfoundby) {
      case FoundBy::Both:
        return powerHeuristic(hitting, looking);
      case FoundBy::Looking:
        return looking > 0 ? 0.f : 1.f;
      case FoundBy::Hitting:
        break;
    }
    return 1;
  }
  bool mayScatter(const PathState& path) const {
    return !params_.maxdepth || path.scatterings < *params_.maxdepth;
  }
  Rgb transmittance(const Ray& ray) const {
    return scene_.volume() ? scene_.volume()->transmittance(ray) : Rgb(1.f);
  }
  const LightTree& lightsFor(const Vec3& p) const {
    return lightsAndMedia_ && emission_.isSeldomHit(p) ? *lightsAndMedia_ : lights_;
  }
  Rgb lightBehind(const PathState& path, const std::optional<SurfaceInteraction>& hit) const;
  float emissionWeight(const PathState& path, const MediumAlongRay& medium) const;
  Rgb equiangularLight(const PathState& path, Segment& segment, RenderContext& context) const;
  static Flight sampleFlight(PathState& path, const Segment& segment, RenderContext& context);
  Towards towardsFrom(const Vec3& p, RenderContext& context) const;
  template <class Vertex, class DistanceWeight>
  Rgb sampleLight(const PathState& path, const Vertex& vertex, const LightTree& lights,
                  const Towards& towards, DistanceWeight&& distanceWeight,
                  RenderContext& context) const;
  template <class Vertex>
  Rgb sampleEmission(const PathState& path, const Vertex& vertex, const Towards& towards,
                     float choice, Vec2 u, RenderContext& context) const;
  template <class Vertex>
  static std::optional<Outgoing> sampleDirection(const Vertex& vertex, const Towards& towards,
                                                 const FootprintRay& ray, RenderContext& context);
  template <class Vertex, class DistanceWeight>
  bool scatter(PathState& path, const Vertex& vertex, DistanceWeight&& distanceWeight,
               RenderContext& context) const;
  bool survives(PathState& path, RenderContext& context) const;
  float lookRoulette(const PathState& path, const BsdfValue& value, float share,
                     RenderContext& context) const;

  Params params_;
  const Scene& scene_;
  EmissionSampler emission_;
  TowardsLights towards_;
  LightTree lights_;  // that vertices look at
  std::optional<LightTree> lightsAndMedia_;
  SegmentLights segmentLights_;
};

VolPath::VolPath(Params params, const FactoryContext& context)
    : params_(params),
      scene_(*context.scene),
      emission_(scene_),
      towards_(scene_),
      lights_(lightsToLookAt(scene_), {{}, evenShare(params)}),
      segmentLights_(scene_, evenShare(params)) {
  if (params.emissionsampling && !emission_.isEmpty())
    lightsAndMedia_.emplace(lights_.lights(),
                            LightTree::Options{emission_.bounds(), evenShare(params)});
}

/// Emission of the surface that the ray meets, or of the sky, weighted against the sampling of
/// lights at the last vertex.
Rgb VolPath::lightBehind(const PathState& path,
                         const std::optional<SurfaceInteraction>& hit) const {
  const Arrival& from = path.arrival;
  if (hit) {
    const Rgb Le = emittedRadiance(*hit);
    if (Le.isBlack() || !from.lights) return Le;
    const float choice = from.lights->probability(from.receiver, hit->areaLight);
    // A light that is never sampled (inside an object instance) shows itself, but lights nothing.
    if (!(choice > 0)) return {};
    return Le * hittingWeight(from.pdf, choice * hit->areaLight->pdfLiAt(from.from, path.ray.d,
                                                                         hit->p, hit->n));
  }
  Rgb L;
  for (const Light* light : scene_.infiniteLights()) {
    const float lightPdf = from.lights ? from.lights->probability(from.receiver, light) *
                                             light->pdfLi(from.from, path.ray.d)
                                       : 0.f;
    L += light->Le(path.ray) * (lightPdf > 0 ? hittingWeight(from.pdf, lightPdf) : 1.f);
  }
  return L;
}

/// Of the media's emission along the present ray, against looking at it from the last vertex.
float VolPath::emissionWeight(const PathState& path, const MediumAlongRay& medium) const {
  const LightTree* lights = path.arrival.lights;
  if (!lights || lights == &lights_) return 1;
  const float choice = lights->probability(path.arrival.receiver, nullptr);
  return hittingWeight(path.arrival.pdf, choice * emission_.pdf(path.ray, medium));
}

/// Light of a small source, scattered at a distance that is drawn evenly in the angle under which
/// the source sees the segment: like 1 / distance^2, which free flights do not follow, so that
/// alone they have no finite variance around a point light. Weighted by the balance heuristic
/// against the light that is sampled at the end of the free flight; both take the same share, which
/// depends on the vertex and the direction alone, against directions that hit the source.
Rgb VolPath::equiangularLight(const PathState& path, Segment& segment,
                              RenderContext& context) const {
  segment.looksAtLights = params_.equiangular && params_.lightfoundby != FoundBy::Hitting &&
                          segmentLights_.mayHelp(segment.medium, segment.channels);
  if (!segment.looksAtLights) return {};
  const float uChoice = context.samples.get1D(), uDistance = context.samples.get1D();
  const auto at =
      segmentLights_.sample(segment.medium, segment.channels, segment.lights, uChoice, uDistance);
  if (!at) return {};
  const MediumCoefficients medium = segment.medium.at(at->t);
  if (!(at->pdf > 0) || medium.sigma_s.isBlack()) return {};

  context.stats.add(Stat::VolumeSamples);
  const Rgb carried = path.throughput * segment.medium.transmittance(at->t) * medium.sigma_s;
  if (carried.isBlack()) return {};
  const MediumVertex vertex(scene_, path.ray, at->t, carried);
  const bool isPoint = at->light->isDelta();
  const auto light = at->light->sampleLi(vertex.p(), isPoint ? Vec2(.5f) : context.samples.get2D());
  if (!light || !(light->pdf > 0) || light->L.isBlack()) return {};
  const Ray shadow = vertex.shadowRay(*light);
  if (scene_.isOccluded(shadow, context.stats)) return {};
  const float choice = lightsFor(vertex.p()).probability(vertex.receiver(), at->light);
  const BsdfValue value = vertex.evaluate(light->wi);
  float share = 1;
  if (!isPoint) {
    const Towards towards = towardsFrom(vertex.p(), context);
    share = lookingWeight(choice * light->pdf, towards.mixed(light->wi, value.pdf));
  }
  const float pdf = (at->pdf + choice * segment.flightPdf(at->t)) * light->pdf;
  return carried * light->L * transmittance(shadow) * value.f * (share / pdf);
}

VolPath::Towards VolPath::towardsFrom(const Vec3& p, RenderContext& context) const {
  if (!params_.towardslights || towards_.isEmpty()) return {};
  return towards_.from(p, context.samples.get1D());
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
  const auto t = segment.medium.invert(channel, -std::log1p(-(double{uDepth} + rest * 0x1p-24)));
  if (!t) {
    const Rgb Tr = segment.medium.transmittance(), reach = channels * Tr;
    path.throughput *= Tr / (reach.r + reach.g + reach.b);
    return flight;
  }
  flight.t = static_cast<float>(*t);
  flight.pdf = segment.flightPdf(*t);
  path.throughput = flight.pdf > 0 ? path.throughput * segment.medium.transmittance(*t) *
                                         segment.medium.at(*flight.t).sigma_s / flight.pdf
                                   : Rgb();
  return flight;
}

/// Next-event estimation: light of one source, chosen for this vertex, that is scattered into the
/// path. distanceWeight(choice) is the weight against looking at it from another distance.
template <class Vertex, class DistanceWeight>
Rgb VolPath::sampleLight(const PathState& path, const Vertex& vertex, const LightTree& lights,
                         const Towards& towards, DistanceWeight&& distanceWeight,
                         RenderContext& context) const {
  if (lights.isEmpty() || params_.lightfoundby == FoundBy::Hitting) return {};
  const float uChoice = context.samples.get1D();
  const Vec2 u = context.samples.get2D();
  const auto choice = lights.choose(vertex.receiver(), uChoice);
  if (!choice) return {};
  if (!choice->light) return sampleEmission(path, vertex, towards, choice->probability, u, context);
  const auto light = choice->light->sampleLi(vertex.p(), u);
  if (!light || !(light->pdf > 0) || light->L.isBlack()) return {};
  const BsdfValue value = vertex.evaluate(light->wi);
  const float pdf = choice->probability * light->pdf;
  const float share =
      choice->light->isDelta() ? 1.f : lookingWeight(pdf, towards.mixed(light->wi, value.pdf));
  const float survivors = lookRoulette(path, value, share, context);
  if (survivors == 0) return {};
  const Ray shadow = vertex.shadowRay(*light);
  if (scene_.isOccluded(shadow, context.stats)) return {};
  return transmittance(shadow) * light->L * value.f *
         (distanceWeight(*choice) * share * survivors / pdf);
}

/// The same for the emission of the media along a direction towards one of their points.
template <class Vertex>
Rgb VolPath::sampleEmission(const PathState& path, const Vertex& vertex, const Towards& towards,
                            float choice, Vec2 u, RenderContext& context) const {
  const auto wi = emission_.sample(vertex.p(), u);
  if (!wi) return {};
  const BsdfValue value = vertex.evaluate(*wi);
  const float survivors = lookRoulette(path, value, 1, context);
  if (survivors == 0) return {};
  // Up to where nothing emits any more.
  FootprintRay ray(vertex.spawn(*wi));
  const auto emitting = emission_.emittersAlong(ray);
  if (!emitting) return {};
  ray.tMax = emitting->t1;
  if (const auto hit = scene_.intersect(ray, context.stats)) ray.tMax = distance(ray.o, hit->p);
  const auto range = scene_.volume()->intersect(ray);
  if (!range) return {};
  thread_local MediumAlongRay medium;  // reused, so that its memory is
  medium.assign(*scene_.volume(), ray, *range);
  const float pdf = choice * emission_.pdf(ray, medium);
  if (!(pdf > 0)) return {};
  const float weight = survivors * lookingWeight(pdf, towards.mixed(*wi, value.pdf));
  return medium.emission() * value.f * (weight / pdf);
}

/// The direction in which the path goes on, around the lights or as the vertex scatters, with the
/// density of the mixture.
template <class Vertex>
std::optional<Outgoing> VolPath::sampleDirection(const Vertex& vertex, const Towards& towards,
                                                 const FootprintRay& ray, RenderContext& context) {
  float uLobe = context.samples.get1D();
  const Vec2 u = context.samples.get2D();
  const float share = towards.share();
  if (uLobe < share) {
    const Vec3 wi = towards.sample(u);
    const BsdfValue value = vertex.evaluate(wi);
    if (value.f.isBlack()) return std::nullopt;
    const float pdf = towards.mixed(wi, value.pdf);
    return Outgoing{FootprintRay(vertex.spawn(wi)), value.f, pdf, false, pdf / value.pdf};
  }
  uLobe = std::min((uLobe - share) / (1 - share), kOneMinusEpsilon);
  auto outgoing = vertex.sample(ray, uLobe, u);
  if (!outgoing || !(outgoing->pdf > 0)) return std::nullopt;
  const float own = outgoing->pdf;
  outgoing->pdf = outgoing->isSpecular ? (1 - share) * own : towards.mixed(outgoing->ray.d, own);
  outgoing->aimed = outgoing->pdf / own;
  return outgoing;
}

/// Light sampled at a vertex, then the direction in which the path goes on. False: it ends.
template <class Vertex, class DistanceWeight>
bool VolPath::scatter(PathState& path, const Vertex& vertex, DistanceWeight&& distanceWeight,
                      RenderContext& context) const {
  Towards towards;
  const PathComponent component = after(path.component, Vertex::kScattering);
  const LightTree* lights = vertex.seesLights() ? &lightsFor(vertex.p()) : nullptr;
  if (lights) {
    towards = towardsFrom(vertex.p(), context);
    addLight(path, component,
             path.throughput * sampleLight(path, vertex, *lights, towards, distanceWeight, context),
             context);
  }
  const auto outgoing = sampleDirection(vertex, towards, path.ray, context);
  if (!outgoing) return false;
  path.throughput *= outgoing->weight / outgoing->pdf;
  path.ray = outgoing->ray;
  path.aimed = outgoing->aimed;
  path.arrival = {outgoing->isSpecular ? nullptr : lights, outgoing->pdf, vertex.p(),
                  vertex.receiver()};
  path.component = outgoing->isSpecular ? after(path.component, Scattering::Specular) : component;
  return true;
}

/// Russian roulette. By the throughput alone, so that a path that has lost nothing goes on: in a
/// medium that absorbs nothing survival is 1, until the path is so long that only a closed scene
/// can hold it. Against what it carried after its first scattering, specular ones apart: all paths
/// of a pixel carry about that, and those of a dark surface are worth as much as those of a white
/// one. A direction drawn around a light carries little because much will be scattered
/// along it: its density is left out here, or survivors would carry as much as if the scattering
/// function had drawn it, and no distance between light and ray would bound what they bring.
bool VolPath::survives(PathState& path, RenderContext& context) const {
  const float carried = path.throughput.maxChannel() * path.aimed;
  if (!(carried > 0)) return false;
  if (path.usual == 0 && path.arrival.lights) path.usual = carried;
  const float least = kRouletteBelow * (path.usual > 0 ? path.usual : 1);
  const float survival =
      std::min(params_.roulette ? std::max(carried / least, kLeastSurvival) : 1.f,
               path.scatterings < kLongPath ? 1.f : kLongPathSurvival);
  if (survival >= 1.f) return true;
  if (context.samples.get1D() >= survival) {
    context.stats.add(Stat::RussianRouletteStops);
    return false;
  }
  path.throughput /= survival;
  return true;
}

/// Russian roulette for a look at a light, before its shadow ray is traced: by 4 pi times the
/// larger of the scattering function and its density for the direction, of which the latter is 1 on
/// the mean over all directions whatever the albedo, times the look's share against rays that hit
/// the light. What fog that scatters forward would turn by a large angle is seldom worth the ray.
/// Not where the camera or a specular bounce gives the direction: all paths of a pixel may see as
/// little there. The weight against other distances of the segment is left out: it falls near a
/// small light as the irradiance grows, and survivors would lose that. Returns the factor of looks
/// that go on, 0 for the others.
float VolPath::lookRoulette(const PathState& path, const BsdfValue& value, float share,
                            RenderContext& context) const {
  if (value.f.isBlack() || !(share > 0)) return 0;
  const float carried = 4 * kPi * std::max(value.f.maxChannel(), value.pdf) * share;
  const float survival = std::max(carried / kRouletteBelow, kLeastSurvival);
  if (!params_.roulette || !path.arrival.lights || survival >= 1) return 1;
  return context.samples.get1D() < survival ? 1 / survival : 0;
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
      segment.lights.forget();
      behind *= segment.medium.transmittance();
      const Rgb emitted = emission_.isEmpty() ? Rgb() : segment.medium.emission();
      if (!emitted.isBlack())
        addLight(path, path.component,
                 path.throughput * emitted * emissionWeight(path, segment.medium), context);
      context.stats.add(Stat::VolumeSegments);
    }
    addLight(path, path.component, path.throughput * behind, context);
    if (!mayScatter(path)) break;

    // Where the path goes on.
    Flight flight;
    if (range) {
      const Rgb& carried = path.throughput;
      segment.channels = carried / (carried.r + carried.g + carried.b);
      segment.looksAtLights = false;
      if (scene_.volume()->isScattering() && !segment.medium.isEmpty())
        addLight(path, after(path.component, Scattering::Medium),
                 equiangularLight(path, segment, context), context);
      flight = sampleFlight(path, segment, context);
    }
    if (!flight.t && !hit) break;
    ++path.scatterings;
    if (path.throughput.isBlack()) break;
    const auto flightWeight = [&](const LightTree::Choice& choice) {
      if (!segment.looksAtLights) return 1.f;
      const float here = choice.probability * flight.pdf;
      return here / (here + segmentLights_.pdf(segment.medium, segment.channels, segment.lights,
                                               *choice.light, *flight.t));
    };
    if (flight.t) context.stats.add(Stat::VolumeSamples);
    const bool goesOn =
        flight.t
            ? scatter(path, MediumVertex(scene_, path.ray, *flight.t, path.throughput),
                      flightWeight, context)
            : scatter(
                  path, SurfaceVertex(*hit), [](const LightTree::Choice&) { return 1.f; }, context);
    if (!goesOn || !survives(path, context)) break;
  }
  return path.L;
}

void VolPath::describe(Plan& plan) const {
  const SceneInventory found = takeInventory(scene_);
  if (found.deltaLights > 0 && found.specularMaterials > 0)
    plan.skip("light without extent through glass or off mirrors",
              "volpath hits lights or looks at them along a straight line");
  if (emittingLights(scene_).size() > lights_.lights().size()) planEvenSky(plan);
  if (found.deltaLights > 0 && params_.lightfoundby == FoundBy::Hitting)
    plan.skip("lights without extent", "no ray hits them (lightfoundby \"hitting\")");
}

const RegisterPlugin<GlobalIntegrator, VolPath> kRegistration{
    "volpath", Origin::Brume,
    "unbiased volumetric path tracing: all light at surfaces and in media"};

}  // namespace
}  // namespace brume
