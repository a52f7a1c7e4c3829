// SPDX-License-Identifier: Apache-2.0
// Scenes of media and simple lights, without surfaces, and ways to run a volume integrator on them.
#pragma once

#include <memory>
#include <vector>

#include "core/integrator.h"
#include "core/rng.h"

namespace brume::test {

/// Isotropic point light, or a cone of light around an axis with PBRT-v2's falloff.
struct PointLightSpec {
  Vec3 from{0};
  Rgb I{1.f};
  Vec3 axis{0, 0, 1};
  float cosTotal = -1, cosStart = -1;  ///< cosTotal = -1: no cone
};
std::unique_ptr<Light> makePointLight(const PointLightSpec& spec);
/// Parallel light that travels along `direction`; L is the irradiance across it.
std::unique_ptr<Light> makeDistantLight(const Vec3& direction, Rgb L);
/// Constant radiance from all sides, sampled uniformly over the sphere.
std::unique_ptr<Light> makeEnvironment(Rgb L);

Scene makeMediaScene(std::vector<std::unique_ptr<Volume>> volumes,
                     std::vector<std::unique_ptr<Light>> lights);

/// Independent uniform numbers; sets are stratified and shuffled.
class StratifiedStream final : public SampleStream {
 public:
  explicit StratifiedStream(std::uint64_t seed) : rng_(seed) {}
  float get1D() override { return rng_.uniform(); }
  Vec2 get2D() override { return rng_.uniform2(); }
  void get1DArray(std::span<float> values) override;
  void get2DArray(std::span<Vec2> values) override;

 private:
  Rng rng_;
};

/// Mean and variance of repeated estimates.
struct Estimate {
  double mean[3] = {0, 0, 0};
  double variance[3] = {0, 0, 0};  ///< of one estimate
  Rgb Tr;
  Stats stats;
};
Estimate estimate(const VolumeIntegrator& integrator, const Ray& ray, int repeats,
                  std::uint64_t seed = 1);

}  // namespace brume::test
