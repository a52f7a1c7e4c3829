// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string_view>

#include "core/math.h"
#include "core/params.h"
#include "core/phase.h"
#include "core/ray.h"
#include "core/rgb.h"
#include "core/transform.h"

namespace brume {

/// Coefficients of a medium at a point. Lengths are world lengths.
struct MediumCoefficients {
  Rgb sigma_a, sigma_s;  ///< absorption and scattering [1/length]
  Rgb Le;  ///< radiance added per unit length (PBRT-v2's meaning: not multiplied by sigma_a)
  Rgb sigma_t() const { return sigma_a + sigma_s; }
};

/// A participating medium in a region of render space. Immutable and thread-safe. Everything that
/// can be computed exactly is. Rays are parametrised by t with a normalised direction, so t is a
/// length; intervals must lie inside the ray.
class Volume {
 public:
  static constexpr std::string_view kPluginKind = "Volume";
  struct FactoryContext {
    Transform volumeToWorld;  ///< CTM shifted to render space
    SourceLocation where;
    Log* log = nullptr;
  };
  virtual ~Volume() = default;

  virtual Bounds3 bounds() const = 0;
  /// The part of (0, ray.tMax) that may hold medium; none when the ray misses.
  virtual std::optional<Interval> intersect(const Ray& ray) const = 0;
  /// All zero outside.
  virtual MediumCoefficients at(const Vec3& p) const = 0;

  /// Int_t0^t1 sigma_t(ray(t)) dt per channel.
  virtual Rgb opticalDepth(const Ray& ray, Interval range) const = 0;
  Rgb transmittance(const Ray& ray, Interval range) const { return exp(-opticalDepth(ray, range)); }
  /// The t in range with Int_t0^t sigma_t[channel] = depth; none when the whole range holds less.
  virtual std::optional<float> invertOpticalDepth(const Ray& ray, Interval range, int channel,
                                                  float depth) const = 0;
  /// Int_t0^t1 exp(-tau(t0, t)) Le(ray(t)) dt.
  virtual Rgb emission(const Ray& ray, Interval range) const = 0;
  virtual bool isEmissive() const = 0;
  virtual bool isScattering() const = 0;

  /// Phase function value at p, the sigma_s-weighted mean where volumes overlap.
  virtual float phase(const Vec3& p, const Vec3& wo, const Vec3& wi) const = 0;
  virtual PhaseSample samplePhase(const Vec3& p, const Vec3& wo, float uComponent,
                                  Vec2 u) const = 0;
};

/// The sum of several volumes.
std::unique_ptr<Volume> makeAggregateVolume(std::vector<const Volume*> volumes);

}  // namespace brume
