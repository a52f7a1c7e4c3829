// SPDX-License-Identifier: Apache-2.0
// Volumes for tests, and slow but sure integrals to compare them with.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "core/rng.h"
#include "core/volume.h"

namespace brume::test {

struct MediumSpec {
  Rgb sigma_a{0.f}, sigma_s{0.f}, Le{0.f};
  Vec3 p0{0}, p1{1};
  float g = 0;
  Rgb sigma_t() const { return sigma_a + sigma_s; }
  Transform volumeToWorld{};
};
std::unique_ptr<Volume> makeHomogeneous(const MediumSpec& spec);
std::unique_ptr<Volume> makeExponential(const MediumSpec& spec, float a, float b,
                                        const Vec3& up = {0, 1, 0});
std::unique_ptr<Volume> makeGrid(const MediumSpec& spec, int nx, int ny, int nz,
                                 std::vector<float> density);
/// Densities uniform in [0, 1), each 0 with the given probability.
std::vector<float> randomDensities(std::size_t count, Rng& rng, float emptyShare = 0);

/// Composite eight-point Gauss-Legendre rule.
double integrate(const std::function<double(double)>& f, double a, double b, int intervals);

Vec3 randomDirection(Rng& rng);

}  // namespace brume::test
