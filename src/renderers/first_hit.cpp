// SPDX-License-Identifier: Apache-2.0
#include "renderers/first_hit.h"

#include "core/bsdf.h"

namespace brume {

void describeFirstHit(const Scene& scene, const FootprintRay& ray, LayerSample& sample,
                      Stats& stats) {
  Ray segment = ray;
  if (const auto hit = scene.intersect(ray, stats)) {
    segment.tMax = distance(ray.o, hit->p);
    Bsdf bsdf;
    hit->material->evaluate(*hit, bsdf);
    sample.hasHit = true;
    sample.depth = segment.tMax;
    sample.normal = bsdf.shadingNormal();
    sample.albedo = bsdf.reflectance(hit->wo, kAllLobes);
  }
  if (scene.volume()) sample.transmittance = scene.volume()->transmittance(segment);
}

}  // namespace brume
