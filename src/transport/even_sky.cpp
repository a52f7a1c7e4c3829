// SPDX-License-Identifier: Apache-2.0
#include "transport/even_sky.h"

#include "transport/light_tree.h"

namespace brume {
namespace {

constexpr double kEven = 2;

}  // namespace

double unevenness(const Light& sky) {
  constexpr int n = 32;  // strata along each axis
  double first = 0, second = 0;
  for (int i = 0; i < n * n; ++i) {
    const Vec2 u((static_cast<float>(i % n) + 0.5f) / n, (static_cast<float>(i / n) + 0.5f) / n);
    const auto sample = sky.sampleLi(Vec3(0), u);
    if (!sample || !(sample->pdf > 0)) continue;
    const double L = lightWeight(sample->L), pdf = sample->pdf;
    first += L / pdf;
    second += L * L / pdf;
  }
  return 4 * double{kPi} * second * n * n / (first * first);
}

std::vector<const Light*> lightsToLookAt(const Scene& scene) {
  std::vector<const Light*> lights = emittingLights(scene);
  std::erase_if(lights, [](const Light* light) {
    return light->isInfinite() && unevenness(*light) <= kEven;
  });
  return lights;
}

void planEvenSky(Plan& plan) {
  plan.skip("looking at the sky", "it is about even: the rays that go on find it as well");
}

}  // namespace brume
