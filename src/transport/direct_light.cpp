// SPDX-License-Identifier: Apache-2.0
#include "transport/direct_light.h"

#include "core/sampling.h"

namespace brume {

Rgb escapedRadiance(const Scene& scene, const Ray& ray) {
  Rgb L;
  for (const Light* light : scene.infiniteLights()) L += light->Le(ray);
  return L;
}

LitSample sampleLight(const LitPoint& point, const Light& light, Vec2 u, LobeFlags lobes,
                      RenderContext& context) {
  const auto [scene, at, bsdf, media] = point;
  const std::optional<LightSample> sample = light.sampleLi(at.p, u);
  if (!sample || !(sample->pdf > 0) || sample->L.isBlack()) return {};
  const BsdfValue value = light.isDelta() ? BsdfValue{bsdf.f(at.wo, sample->wi, lobes), 0.f}
                                          : bsdf.evaluate(at.wo, sample->wi, lobes);
  if (value.f.isBlack()) return {};
  const Ray shadow = Scene::shadowRay(at, *sample);
  if (scene.isOccluded(shadow, context.stats)) return {};

  LitSample lit;
  lit.value = value.f * sample->L * (absDot(sample->wi, bsdf.shadingNormal()) / sample->pdf);
  if (scene.volume()) lit.value *= media.transmittance(shadow, context);
  lit.lightPdf = sample->pdf;
  lit.bsdfPdf = value.pdf;
  return lit;
}

namespace {

/// The light's radiance along `ray` where it is the first thing met, with its density.
struct FoundLight {
  Rgb L;
  float pdf = 0;
  float distance = kInfinity;
};
FoundLight findLight(const LitPoint& point, const Light& light, const Ray& ray,
                     RenderContext& context) {
  if (light.isInfinite()) {
    const float pdf = light.pdfLi(point.at.p, ray.d);
    if (!(pdf > 0) || point.scene.isOccluded(ray, context.stats)) return {};
    return {light.Le(ray), pdf, kInfinity};
  }
  const auto hit = point.scene.intersect(FootprintRay(ray), context.stats);
  if (!hit || hit->areaLight != &light) return {};
  return {emittedRadiance(*hit), hit->areaLight->pdfLiAt(point.at.p, ray.d, hit->p, hit->n),
          distance(ray.o, hit->p)};
}

}  // namespace

Rgb estimateDirect(const LitPoint& point, const Light& light, const DirectSample& u,
                   RenderContext& context) {
  const LitSample lit = sampleLight(point, light, u.light, kNonSpecular, context);
  if (light.isDelta()) return lit.value;
  Rgb L = lit.value * powerHeuristic(lit.lightPdf, lit.bsdfPdf);

  const SurfaceInteraction& at = point.at;
  const auto scattered = point.bsdf.sample(at.wo, u.lobe, u.direction, kNonSpecular);
  if (!scattered || !(scattered->pdf > 0) || scattered->f.isBlack()) return L;
  Ray ray = at.spawnRay(scattered->wi);
  const FoundLight found = findLight(point, light, ray, context);
  if (!(found.pdf > 0) || found.L.isBlack()) return L;
  Rgb value = scattered->f * found.L *
              (absDot(scattered->wi, point.bsdf.shadingNormal()) / scattered->pdf *
               powerHeuristic(scattered->pdf, found.pdf));
  if (point.scene.volume()) {
    ray.tMax = found.distance;
    value *= point.media.transmittance(ray, context);
  }
  return L + value;
}

}  // namespace brume
