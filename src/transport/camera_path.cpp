// SPDX-License-Identifier: Apache-2.0
#include "transport/camera_path.h"

#include "core/material.h"
#include "transport/direct_light.h"
#include "transport/specular.h"

namespace brume {
namespace {

/// Specular bounces after which roulette may end a path.
constexpr int kRouletteBounce = 3;
constexpr LobeFlags kSpecularLobes = kSpecular | kReflection | kTransmission;

}  // namespace

CameraPaths::CameraPaths(const Scene& scene, const Options& options)
    : scene_(scene),
      options_(options),
      lights_(scene),
      media_(scene.volume()),
      unscattered_(scene) {}

Rgb CameraPaths::direct(const SurfaceInteraction& at, const Bsdf& bsdf,
                        RenderContext& context) const {
  const float uChoice = context.samples.get1D();
  DirectSample u;
  u.light = context.samples.get2D();
  u.lobe = context.samples.get1D();
  u.direction = context.samples.get2D();
  const auto choice = lights_.choose(PointReceiver(at.p, at.n), uChoice);
  if (!choice) return {};
  return estimateDirect({scene_, at, bsdf, media_}, *choice->light, u, context) /
         choice->probability;
}

/// Goes on by a specular lobe. False: the path ends.
bool CameraPaths::bounce(FootprintRay& ray, Rgb& weight, const SurfaceInteraction& at,
                         const Bsdf& bsdf, int bounces, RenderContext& context) const {
  const float uLobe = context.samples.get1D(), uSurvival = context.samples.get1D();
  const Vec2 u = context.samples.get2D();
  if (bounces >= options_.maxBounces || bsdf.countMatching(kSpecularLobes) == 0) return false;
  const auto sample = bsdf.sample(at.wo, uLobe, u, kSpecularLobes);
  if (!sample || !(sample->pdf > 0)) return false;
  weight *= sample->f * (absDot(sample->wi, bsdf.shadingNormal()) / sample->pdf);
  if (weight.isBlack()) return false;
  if (bounces >= kRouletteBounce) {
    const float survival = std::min(1.f, weight.maxChannel());
    if (uSurvival >= survival) {
      context.stats.add(Stat::RussianRouletteStops);
      return false;
    }
    weight /= survival;
  }
  ray = specularRay(ray, at, bsdf.shadingNormal(), *sample);
  return true;
}

Rgb CameraPaths::follow(const FootprintRay& cameraRay, CameraPathVisitor& visitor,
                        RenderContext& context) const {
  FootprintRay ray = cameraRay;
  Rgb L, weight(1.f);
  thread_local MediumAlongRay medium;  // reused, so that its memory is
  const Volume* volume = scene_.volume();
  for (int bounces = 0;; ++bounces) {
    const auto hit = scene_.intersect(ray, context.stats);
    context.stats.add(Stat::PathSegments);
    if (hit) ray.tMax = distance(ray.o, hit->p);
    if (const auto range = volume ? volume->intersect(ray) : std::nullopt) {
      context.stats.add(Stat::VolumeSegments);
      medium.assign(*volume, ray, *range);
      if (volume->isEmissive()) L += weight * medium.emission();
      if (volume->isScattering() && !medium.isEmpty()) {
        if (options_.unscatteredVolume) L += weight * unscattered_.estimate(medium, context);
        visitor.onSegment(medium, weight, bounces);
      }
      weight *= medium.transmittance();
    }
    if (!hit) return L + weight * escapedRadiance(scene_, ray);

    L += weight * emittedRadiance(*hit);
    Bsdf bsdf;
    hit->material->evaluate(*hit, bsdf);
    if (!bsdf.isSpecularOnly()) {
      if (options_.directSurface) L += weight * direct(*hit, bsdf, context);
      visitor.onSurface(*hit, bsdf, weight);
    }
    if (!bounce(ray, weight, *hit, bsdf, bounces, context)) return L;
  }
}

}  // namespace brume
