// SPDX-License-Identifier: Apache-2.0
#include "renderers/camera_radiance.h"

#include "transport/direct_light.h"

namespace brume {

Rgb CameraRadiance::Li(const FootprintRay& ray, int depth, RenderContext& context) const {
  const auto hit = scene_.intersect(ray, context.stats);
  // The media come first: they are the noisier part and get the better distributed dimensions.
  VolumeRadiance volume;
  if (scene_.volume()) {
    Ray segment = ray;
    if (hit) segment.tMax = distance(ray.o, hit->p);
    volume = media_.integrate(segment, context);
    if (volume.Tr.isBlack()) return volume.Lv;
  }
  if (!hit) return volume.Tr * escapedRadiance(scene_, ray) + volume.Lv;
  context.stats.add(Stat::SurfaceHits);
  return volume.Tr * surface_.Li({ray, *hit, depth, *this, media_}, context) + volume.Lv;
}

}  // namespace brume
