// SPDX-License-Identifier: Apache-2.0
#include "transport/segment_lights.h"

#include "transport/distance_sampling.h"

namespace brume {
namespace {

/// V from which a segment looks at a light.
constexpr double kWorthLooking = 0.25;
/// The same for lights with an extent, whose variance is bounded and which directions find as well:
/// from there on it paid for lamps of 2 and 7 % of the media in fog of sigma R = 0.1 to 2.
constexpr double kWorthLookingAtArea = 2;
/// The maximum of x exp(-2 x), at x = 1/2.
constexpr double kMostFound = 0.18394;

/// Of the media's radius: lights of a larger extent are found by flights and directions alone.
constexpr double kSmallLight = 0.1;

/// Lights that may be looked at: those of one point, and small ones.
bool isSmall(const Light& light, double mediaRadius) {
  return light.position() && double{light.extent()} <= kSmallLight * mediaRadius;
}

std::vector<const Light*> smallLights(const Scene& scene) {
  std::vector<const Light*> result;
  if (!scene.volume()) return result;
  const double mediaRadius = double{scene.volume()->bounds().radius()};
  for (const Light* light : emittingLights(scene))
    if (isSmall(*light, mediaRadius)) result.push_back(light);
  return result;
}

/// Mean over the channels that may draw a flight.
double drawn(const Rgb& channels, const Rgb& depth) {
  const Rgb sum = channels * depth;
  return double{sum.r} + double{sum.g} + double{sum.b};
}

/// A point as seen from a segment.
struct View {
  double length;    // of the segment
  double nearest;   // t of its point nearest to p
  double distance;  // from there

  View(const MediumAlongRay& medium, const Vec3d& p) {
    const Ray& ray = medium.ray();
    const Interval range = medium.range();
    const Vec3d toPoint = p - Vec3d(ray.o), d(ray.d);
    length = double{range.t1} - double{range.t0};
    nearest = std::clamp(dot(toPoint, d), double{range.t0}, double{range.t1});
    const Vec3d between = toPoint - d * nearest;
    distance = std::sqrt(dot(between, between));
  }
};

double distanceFrom(const Bounds3& box, const Vec3& p) {
  const Vec3d outside = max(max(Vec3d(box.lo) - Vec3d(p), Vec3d(p) - Vec3d(box.hi)), Vec3d(0));
  return std::sqrt(dot(outside, outside));
}

/// (N / n)^4 / min(1, sigma R)^2
double relativeIrradiance2(double sigma, double mediaRadius, double outside, double distance) {
  const double typical = std::max(std::min(1 / sigma, mediaRadius), outside);
  const double irradiance = sqr(typical / distance) / std::min(1.0, sigma * mediaRadius);
  return sqr(irradiance);
}

}  // namespace

SegmentLights::SegmentLights(const Scene& scene, double evenShare)
    : lights_(smallLights(scene), {{}, evenShare}) {
  if (!scene.volume() || lights_.isEmpty()) return;
  media_ = scene.volume()->bounds();
  mediaRadius_ = double{media_.radius()};
  Bounds3 bounds;
  for (const Light* light : lights_.lights()) {
    bounds.extend(*light->position());
    farthestOutside_ = std::max(farthestOutside_, distanceFrom(media_, *light->position()));
  }
  center_ = Vec3d(bounds.center());
  radius_ = 1.0001 * double{bounds.radius()};
  findLeastExtinction();
}

/// By bisection: the bound falls as the extinction grows.
void SegmentLights::findLeastExtinction() {
  double nearest = HUGE_VAL;
  for (const Light* light : lights_.lights())
    nearest = std::min(nearest, distanceFrom(media_, *light->position()));
  const auto isHelpless = [&](double sigma) {
    return kMostFound * relativeIrradiance2(sigma, mediaRadius_, farthestOutside_, nearest) <=
           kWorthLooking;
  };
  double low = 1e-6 / mediaRadius_, high = 1e6 / mediaRadius_;
  if (!(nearest > 0) || !isHelpless(high)) return;
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(low * high);
    (isHelpless(middle) ? high : low) = middle;
  }
  helplessExtinction_ = high;
}

bool SegmentLights::mayHelp(const MediumAlongRay& medium, const Rgb& channels) const {
  if (lights_.isEmpty()) return false;
  if (medium.isTracked()) return true;  // whose depths are random
  const double depth = drawn(channels, medium.opticalDepth());
  const Interval range = medium.range();
  if (depth > helplessExtinction_ * (double{range.t1} - double{range.t0})) return false;
  const View view(medium, center_);
  const double nearest = view.distance - radius_;
  if (!(nearest > 0)) return true;
  const double sigma = depth / view.length;
  return kMostFound * relativeIrradiance2(sigma, mediaRadius_, farthestOutside_, nearest) >
         kWorthLooking;
}

bool SegmentLights::looksAt(const MediumAlongRay& medium, const Rgb& channels, const Vec3& p,
                            float extent) const {
  if (medium.isTracked()) return true;
  const View view(medium, Vec3d(p));
  const double sigma = drawn(channels, medium.opticalDepth()) / view.length;
  if (!(sigma > 0)) return false;
  const double distance = std::sqrt(sqr(view.distance) + 0.25 * sqr(double{extent}));
  const double most = relativeIrradiance2(sigma, mediaRadius_, distanceFrom(media_, p),
                                          std::max(distance, 1e-6 * view.length));
  const double worth = extent > 0 ? kWorthLookingAtArea : kWorthLooking;
  if (kMostFound * most <= worth) return false;
  const double x = sigma * std::min(distance, view.length);
  const double tau = drawn(channels, medium.opticalDepth(static_cast<float>(view.nearest)));
  return x * std::exp(-2 * x - tau) * most > worth;
}

const LightTree::Cut<RayReceiver>& SegmentLights::cutFor(const MediumAlongRay& medium,
                                                         Chances& chances) const {
  if (!chances.isKnown_) chances.cut_ = lights_.cut(RayReceiver(medium.ray(), medium.range()));
  chances.isKnown_ = true;
  return chances.cut_;
}

std::optional<SegmentLights::Sample> SegmentLights::sample(const MediumAlongRay& medium,
                                                           const Rgb& channels, Chances& chances,
                                                           float uChoice, float uDistance) const {
  const Ray& ray = medium.ray();
  const Interval range = medium.range();
  const auto choice = lights_.choose(cutFor(medium, chances), uChoice);
  if (!choice) return std::nullopt;
  const Vec3 position = *choice->light->position();
  const float extent = choice->light->extent();
  if (!looksAt(medium, channels, position, extent)) return std::nullopt;
  const Interval part = choice->light->illuminated(ray, range);
  if (part.isEmpty()) return std::nullopt;
  const DistanceSample at = EquiangularSampler(ray, part, position, extent).sample(uDistance);
  return Sample{choice->light, at.t, choice->probability * at.pdf};
}

float SegmentLights::pdf(const MediumAlongRay& medium, const Rgb& channels, Chances& chances,
                         const Light& light, float t) const {
  if (!isSmall(light, mediaRadius_)) return 0;
  const Vec3 position = *light.position();
  if (!looksAt(medium, channels, position, light.extent())) return 0;
  const Ray& ray = medium.ray();
  const Interval range = medium.range(), part = light.illuminated(ray, range);
  if (part.isEmpty() || !(t >= part.t0 && t <= part.t1)) return 0;
  return lights_.probability(cutFor(medium, chances), &light) *
         EquiangularSampler(ray, part, position, light.extent()).pdf(t);
}

}  // namespace brume
