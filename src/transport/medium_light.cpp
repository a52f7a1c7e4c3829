// SPDX-License-Identifier: Apache-2.0
#include "transport/medium_light.h"

namespace brume {

namespace {

/// Peak over isotropic above which the phase function is sampled as well: g about 0.4 for
/// Henyey-Greenstein.
constexpr float kPeaked = 4;

/// What arrives along a direction, and its density under light sampling.
struct Arrival {
  Rgb L;
  float lightPdf = 0;
};

Rgb attenuated(const Scene& scene, const Rgb& L, const Ray& shadow, Stats& stats) {
  if (L.isBlack() || scene.isOccluded(shadow, stats)) return {};
  return scene.volume() ? L * scene.volume()->transmittance(shadow) : L;
}

/// Light of one area or infinite light along a direction that the phase function chose.
Arrival arrival(const Scene& scene, const MediumVertex& vertex, const Light& light, const Vec3& wi,
                Stats& stats) {
  FootprintRay ray{Ray{vertex.p, wi, kInfinity, vertex.time}};
  if (light.isInfinite()) {
    const float pdf = light.pdfLi(vertex.p, wi);
    return {attenuated(scene, light.Le(ray), ray, stats), pdf};
  }
  const auto hit = scene.intersect(ray, stats);
  if (!hit || hit->areaLight != &light) return {};
  const auto& area = static_cast<const AreaLight&>(light);
  Arrival a{area.L(hit->p, hit->n, hit->uv, -wi), area.pdfLiAt(vertex.p, wi, hit->p, hit->n)};
  ray.tMax = distance(vertex.p, hit->p);
  if (scene.volume() && !a.L.isBlack()) a.L *= scene.volume()->transmittance(ray);
  return a;
}

/// The unit vector w, turned towards another one by an angle below pi with this 1 - cos, no
/// further.
Vec3 turned(const Vec3& w, const Vec3& to, float oneMinusCos) {
  const float cosine = 1 - oneMinusCos, c = dot(w, to);
  if (c >= cosine) return to;
  const float sine = std::sqrt(oneMinusCos * (1 + cosine));
  const float between = std::sqrt(std::max(1e-12f, 1 - c * c));
  return w * (cosine - c * sine / between) + to * (sine / between);
}

/// Probability of phase sampling where the light lies in a ball. Phase functions peak forwards or
/// backwards, so the largest value towards the ball lies at the border nearest to one of the two.
float phaseShareOfBall(const Volume& volume, const MediumVertex& vertex, const Ball& ball) {
  constexpr float kLeast = 0.05f, kMost = 0.5f;
  const float oneMinusCos = oneMinusCosSeen(vertex.p, ball);
  if (!(oneMinusCos < 1)) return kMost;
  const Vec3 middle = normalize(ball.center - vertex.p);
  const auto phase = [&](const Vec3& to) {
    return volume.phase(vertex.p, vertex.wo, turned(middle, to, oneMinusCos)).maxChannel();
  };
  const float byPhase = std::max(phase(-vertex.wo), phase(vertex.wo));
  const float share = byPhase / (byPhase + 1 / (2 * kPi * oneMinusCos));
  return share < kLeast ? 0 : std::min(share, kMost);
}

/// Probability of phase sampling at a vertex. A light that looks smaller than the lobe, or lies
/// beside it, is sampled better by itself.
float phaseShare(const Volume& volume, const MediumVertex& vertex, const Light& light) {
  if (!wantsPhaseSampling(volume, light)) return 0;
  if (const auto position = light.position())
    return phaseShareOfBall(volume, vertex, {*position, light.extent()});
  const auto middle = light.sampleLi(vertex.p, Vec2(0.5f));
  if (!middle || !(middle->pdf > 0)) return 0.5f;
  const float peak = volume.phasePeak();
  return std::clamp(peak / (peak + middle->pdf), 0.05f, 0.5f);
}

}  // namespace

bool wantsPhaseSampling(const Volume& volume, const Light& light) {
  return !light.isDelta() && volume.phasePeak() > kPeaked * kInv4Pi;
}

Rgb estimateInscattering(const Scene& scene, const MediumVertex& vertex, const Light& light,
                         const MediumLightUniforms& u, Stats& stats) {
  const Volume& volume = *scene.volume();
  const float q = phaseShare(volume, vertex, light);

  if (u.technique < q) {
    const ScatterSample s =
        volume.samplePhase(vertex.p, vertex.wo, vertex.carried, u.lobe, u.phase);
    if (!(s.pdf > 0)) return {};
    const Arrival a = arrival(scene, vertex, light, s.wi, stats);
    return a.L * s.value / (q * s.pdf + (1 - q) * a.lightPdf);
  }

  const auto s = light.sampleLi(vertex.p, u.light);
  if (!s || !(s->pdf > 0)) return {};
  const Rgb p = volume.phase(vertex.p, vertex.wo, s->wi);
  const float pdf = q * phasePdf(p, vertex.carried) + (1 - q) * s->pdf;
  const Ray shadow = Scene::shadowRay(vertex.p, vertex.time, *s);
  return attenuated(scene, s->L * p / pdf, shadow, stats);
}

}  // namespace brume
