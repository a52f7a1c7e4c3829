// SPDX-License-Identifier: Apache-2.0
// The camera's side of all photon methods: what a camera ray meets, through mirrors and glass.
#pragma once

#include "core/bsdf.h"
#include "core/integrator.h"
#include "core/medium_along_ray.h"
#include "transport/light_tree.h"
#include "transport/media_transmittance.h"
#include "transport/unscattered_light.h"

namespace brume {

/// Takes what a camera path meets; weights are what a radiance there is multiplied with on its way
/// to the pixel.
class CameraPathVisitor {
 public:
  virtual ~CameraPathVisitor() = default;
  /// A stretch of the path inside media. `weight` is that of its start; attenuation inside is the
  /// visitor's. `bounces` counts the specular ones before.
  virtual void onSegment(const MediumAlongRay& medium, const Rgb& weight, int bounces) = 0;
  /// A surface point with lobes that are not specular.
  virtual void onSurface(const SurfaceInteraction& at, const Bsdf& bsdf, const Rgb& weight) = 0;
};

/// Follows camera rays and gathers what needs no photons:
///   - emission of surfaces, sky and media, seen directly or by specular bounces;
///   - direct light on surfaces, from one light chosen by importance, by multiple importance
///     sampling;
///   - unscattered light in the media, when asked for.
/// Specular lobes are followed by one branch chosen at random, with roulette; at most maxBounces.
/// Immutable and thread-safe.
class CameraPaths {
 public:
  struct Options {
    int maxBounces = 16;            ///< specular ones
    bool directSurface = true;      ///< direct light on surfaces here
    bool unscatteredVolume = true;  ///< unscattered light in media here
  };
  CameraPaths(const Scene& scene, const Options& options);

  /// Radiance gathered along the path; the visitor is told of the rest.
  Rgb follow(const FootprintRay& cameraRay, CameraPathVisitor& visitor,
             RenderContext& context) const;

 private:
  Rgb direct(const SurfaceInteraction& at, const Bsdf& bsdf, RenderContext& context) const;
  bool bounce(FootprintRay& ray, Rgb& weight, const SurfaceInteraction& at, const Bsdf& bsdf,
              int bounces, RenderContext& context) const;

  const Scene& scene_;
  Options options_;
  LightTree lights_;
  MediaTransmittance media_;
  UnscatteredLight unscattered_;
};

}  // namespace brume
