// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <bit>

#include "core/integrator.h"
#include "core/log.h"
#include "core/medium_along_ray.h"
#include "core/registry.h"
#include "core/rng.h"
#include "transport/distance_sampling.h"
#include "transport/light_choice.h"
#include "transport/medium_light.h"

namespace brume {

namespace {

enum class Method { Mis, March };

/// Emission, absorption and single scattering along the ray.
///   Lv = Int Tr(0,t) [Le(t) + sigma_s(t) Int_S2 p(w', w) L_light(x_t, w') V Tr dw'] dt
///                                                                       [W m^-2 sr^-1]
/// Emission and all transmittances are exact. method "mis": `samples` distances per ray, each for
/// one light chosen by the irradiance it sheds along the ray. Distances are spread
/// evenly by equiangular and transmittance sampling, light and phase function sampling give the
/// direction; both pairs are combined by the balance heuristic. Unbiased.
/// method "march": PBRT-v2's fixed steps with a random offset and a light chosen evenly, for
/// comparison; unbiased too, because the transmittance reaches the end of the ray here.
/// Surfaces of any kind cast shadows, glass too (PBRT-v2).
/// Sources: PBRT-v2 for the plugin; Kulla, Fajardo 2012 for the sampling. Test: single_test.
class Single final : public VolumeIntegrator {
 public:
  struct Params {
    std::optional<float> stepsize;
    int samples = 8;
    Method method = Method::Mis;
    void visit(ParamVisitor& v) {
      v(stepsize, "stepsize", kPositive, Unit::Length,
        "length of a step of method \"march\", 1 when not given; no effect with \"mis\"");
      v(samples, "samples", Range<int>{1, 4096}, Unit::Samples,
        "distances per ray at which method \"mis\" gathers light");
      v(method, "method", {{"mis", Method::Mis}, {"march", Method::March}},
        "mis: distances drawn where the light is; march: PBRT-v2's fixed steps");
    }
  };

  Single(const Params& params, const FactoryContext& context)
      : scene_(*context.scene),
        volume_(scene_.volume()),
        params_(params),
        stepSize_(params.stepsize.value_or(1.f)),
        lights_(scene_.lights()) {
    if (params.method == Method::Mis && params.stepsize && context.log)
      context.log->verbose(
          "single: \"stepsize\" has no effect, transmittance and emission are exact and distances "
          "are drawn by importance; \"string method\" \"march\" steps as PBRT-v2 does");
    if (params.method == Method::March && volume_) checkStepCount(context);
    scatters_ = volume_ && volume_->isScattering() && !lights_.isEmpty();
    for (const auto& light : scene_.lights()) usesPoints_ = usesPoints_ || !light->isDelta();
    if (volume_)
      for (const auto& light : scene_.lights())
        samplesPhase_ = samplesPhase_ || wantsPhaseSampling(*volume_, *light);
  }

  VolumeRadiance integrate(const Ray& ray, RenderContext& context) const override {
    if (!volume_) return {};
    const auto range = volume_->intersect(ray);
    if (!range) return {};
    context.stats.add(Stat::VolumeSegments);
    thread_local MediumAlongRay medium;  // reused, so that its memory is
    medium.assign(*volume_, ray, *range);

    VolumeRadiance result;
    result.Tr = medium.transmittance();
    if (params_.method == Method::March) {
      result.Lv = march(medium, context);
    } else {
      if (volume_->isEmissive()) result.Lv = medium.emission();
      if (scatters_) result.Lv += scattered(medium, context);
    }
    result.Lv = context.stats.checkRadiance(result.Lv);
    return result;
  }

  Rgb transmittance(const Ray& ray, RenderContext&) const override {
    return volume_ ? volume_->transmittance(ray) : Rgb(1.f);
  }

 private:
  /// Steps across the whole media are bounded, so that no scene takes for ever.
  void checkStepCount(const FactoryContext& context) const {
    constexpr double kMaxSteps = 1e6;
    const double steps = double{length(volume_->bounds().diagonal())} / double{stepSize_};
    if (steps > kMaxSteps)
      throw SceneError(context.where,
                       fmt::format("\"stepsize\" {:g} takes {:.0f} steps across the media; at most "
                                   "{:.0f} are allowed",
                                   stepSize_, steps, kMaxSteps));
  }

  Rgb scattered(const MediumAlongRay& medium, RenderContext& context) const {
    thread_local LightChoice::Choices choices;
    thread_local std::vector<Vec2> uPoint;
    const auto n = static_cast<std::size_t>(params_.samples);
    // The same number of dimensions is taken whatever the ray meets.
    const float distanceOffset = context.samples.getShift();
    const float lightOffset = lights_.size() > 1 ? context.samples.get1D() : 0.f;
    if (usesPoints_) {
      uPoint.resize(n);
      context.samples.get2DArray(uPoint);
    }
    Vec2 phaseStart{0}, choiceStart{0};
    if (samplesPhase_) {
      phaseStart = context.samples.get2D();
      choiceStart = context.samples.get2D();
    }
    if (medium.isEmpty()) return {};

    const Ray& ray = medium.ray();
    lights_.along(ray, medium.range(), choices);
    if (choices.isEmpty()) return {};
    // Lights come in order, so that each takes its distances in one go.
    Rgb sum;
    std::size_t i = 0;
    while (i < n) {
      const auto& chosen = choices.choose(spaced(i, n, lightOffset));
      std::size_t end = i + 1;
      while (end < n && &choices.choose(spaced(end, n, lightOffset)) == &chosen) ++end;
      const auto at = [&](std::size_t k) {
        MediumLightUniforms u;
        if (usesPoints_) u.light = uPoint[k];
        if (samplesPhase_) {
          // Additive recurrences: with the golden ratio, the root of 2, and in the plane with the
          // powers of the plastic number (Roberts 2018).
          const auto i1 = static_cast<float>(k);
          u.technique = fraction(choiceStart.x + i1 * .618034f);
          u.lobe = fraction(choiceStart.y + i1 * .414214f);
          u.phase = {fraction(phaseStart.x + i1 * .754878f),
                     fraction(phaseStart.y + i1 * .569840f)};
        }
        return u;
      };
      const auto count = static_cast<int>(end - i);
      sum += lightOf(chosen, medium, count, distanceOffset, context.stats,
                     [&](int k) { return at(i + static_cast<std::size_t>(k)); }) *
             (static_cast<float>(count) / chosen.probability);
      i = end;
    }
    return sum / static_cast<float>(n);
  }

  /// What one light sheds along the ray, by n distances.
  template <class Uniforms>
  Rgb lightOf(const LightChoice::Choices::Chosen& chosen, const MediumAlongRay& medium, int n,
              float offset, Stats& stats, Uniforms&& uniforms) const {
    using Technique = ScatteringDistanceSampler::Technique;
    const ScatteringDistanceSampler distances(medium, chosen.illuminated, chosen.light->position(),
                                              chosen.light->extent());
    if (distances.isEmpty()) return {};
    const auto gather = [&](const std::optional<ScatteringDistanceSampler::Sample>& at, int k) {
      if (!at || at->medium.sigma_s.isBlack()) return Rgb();
      stats.add(Stat::VolumeSamples);
      const Ray& ray = medium.ray();
      const Rgb carried = at->medium.sigma_s * at->Tr;
      return estimateInscattering(scene_, {ray(at->t), -ray.d, ray.time, carried}, *chosen.light,
                                  uniforms(k), stats) *
             carried / at->pdf;
    };
    if (n == 1) return gather(distances.sample(offset), 0);

    // The light's own cut, a cone's border, is soft.
    const bool isCut =
        chosen.illuminated.t0 > medium.range().t0 && chosen.illuminated.t1 < medium.range().t1;
    const Ends ends = isCut ? Ends::Vanish : Ends::Jump;

    // Each technique integrates its part of the balance heuristic by a rule of its own.
    Rgb sum;
    int first = 0;
    for (const Technique technique : {Technique::Angle, Technique::Collisions}) {
      const float share = distances.share(technique);
      const int count = share == 1 ? n : share == 0 ? 0 : first == 0 ? n / 2 : n - n / 2;
      for (int k = 0; k < count; ++k) {
        const RulePoint point = evenRule(k, count, offset, ends);
        sum += gather(distances.sample(technique, point.u), first + k) *
               (point.weight * share / static_cast<float>(count));
      }
      first += count;
    }
    return sum;
  }

  static float fraction(float x) { return x - std::floor(x); }
  /// Number i of n evenly spaced ones with one offset.
  static float spaced(std::size_t i, std::size_t n, float offset) {
    return std::min((static_cast<float>(i) + offset) / static_cast<float>(n), kOneMinusEpsilon);
  }

  Rgb march(const MediumAlongRay& medium, RenderContext& context) const {
    const Interval range = medium.range();
    const int steps = std::max(1, static_cast<int>(std::ceil(range.length() / stepSize_)));
    const float step = range.length() / static_cast<float>(steps);
    const float offset = context.samples.get1D();
    // The number of steps is not bounded by the sampler's dimensions: two of them seed the rest.
    const Vec2 seed = context.samples.get2D();
    Rng rng(
        hashIntegers(std::bit_cast<std::uint32_t>(seed.x), std::bit_cast<std::uint32_t>(seed.y)));

    const Ray& ray = medium.ray();
    const auto lightCount = static_cast<std::uint32_t>(scene_.lights().size());
    Rgb sum;
    float roulette = 1;
    for (int i = 0; i < steps; ++i) {
      const float t = range.t0 + (static_cast<float>(i) + offset) * step;
      Rgb Tr = medium.transmittance(t) * roulette;
      // PBRT-v2's roulette: half of the rays go on once little light is left.
      if (Tr.luminance() < 1e-3f) {
        if (rng.uniform() > 0.5f) break;
        roulette *= 2;
        Tr *= 2;
      }
      const MediumCoefficients at = medium.at(t);
      sum += Tr * at.Le;
      if (!scatters_ || at.sigma_s.isBlack()) continue;
      context.stats.add(Stat::VolumeSamples);
      const Light& light = *scene_.lights()[rng.below(lightCount)];
      MediumLightUniforms u;
      u.light = rng.uniform2();
      u.technique = rng.uniform();
      u.lobe = rng.uniform();
      u.phase = rng.uniform2();
      sum += Tr * at.sigma_s * static_cast<float>(lightCount) *
             estimateInscattering(scene_, {ray(t), -ray.d, ray.time, at.sigma_s}, light, u,
                                  context.stats);
    }
    return sum * step;
  }

  const Scene& scene_;
  const Volume* volume_;
  Params params_;
  float stepSize_;
  LightChoice lights_;
  bool scatters_ = false;
  bool usesPoints_ = false;  // some light is no delta distribution
  bool samplesPhase_ = false;
};

const RegisterPlugin<VolumeIntegrator, Single> kRegistration{
    "single", Origin::PbrtV2, "emission, absorption and single scattering of media"};

}  // namespace

}  // namespace brume
