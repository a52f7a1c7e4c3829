// SPDX-License-Identifier: Apache-2.0
#include "support/volumes.h"

#include "core/sampling.h"
#include "support/make_plugin.h"

namespace brume::test {

namespace {

std::vector<Param> common(const MediumSpec& s) {
  return {color("sigma_a", s.sigma_a), color("sigma_s", s.sigma_s), color("Le", s.Le),
          points("p0", {s.p0}),        points("p1", {s.p1}),        floats("g", {s.g})};
}

std::unique_ptr<Volume> makeVolume(const char* name, const MediumSpec& spec,
                                   std::vector<Param> params) {
  Volume::FactoryContext context;
  context.volumeToWorld = spec.volumeToWorld;
  for (Param& p : common(spec)) params.push_back(std::move(p));
  return make<Volume>(name, std::move(params), context);
}

}  // namespace

std::unique_ptr<Volume> makeHomogeneous(const MediumSpec& spec) {
  return makeVolume("homogeneous", spec, {});
}

std::unique_ptr<Volume> makeExponential(const MediumSpec& spec, float a, float b, const Vec3& up) {
  return makeVolume("exponential", spec,
                    {floats("a", {a}), floats("b", {b}), vectors("updir", {up})});
}

std::unique_ptr<Volume> makeGrid(const MediumSpec& spec, int nx, int ny, int nz,
                                 std::vector<float> density) {
  return makeVolume("volumegrid", spec,
                    {integers("nx", {nx}), integers("ny", {ny}), integers("nz", {nz}),
                     floats("density", std::move(density))});
}

std::vector<float> randomDensities(std::size_t count, Rng& rng, float emptyShare) {
  std::vector<float> density(count);
  for (float& d : density) d = rng.uniform() < emptyShare ? 0.f : rng.uniform();
  return density;
}

double integrate(const std::function<double(double)>& f, double a, double b, int intervals) {
  constexpr double kNode[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                               0.9602898564975363};
  constexpr double kWeight[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                 0.1012285362903763};
  double sum = 0;
  const double half = 0.5 * (b - a) / intervals;
  for (int i = 0; i < intervals; ++i) {
    const double middle = a + (2 * i + 1) * half;
    for (int k = 0; k < 4; ++k)
      sum += kWeight[k] * (f(middle - half * kNode[k]) + f(middle + half * kNode[k]));
  }
  return sum * half;
}

Vec3 randomDirection(Rng& rng) { return normalize(sampleUniformSphere(rng.uniform2())); }

}  // namespace brume::test
