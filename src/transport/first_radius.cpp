// SPDX-License-Identifier: Apache-2.0
#include "transport/first_radius.h"

#include <algorithm>
#include <array>

#include "accelerators/beam_photon.h"
#include "accelerators/photon_kdtree.h"
#include "core/camera.h"
#include "core/film.h"
#include "core/medium_along_ray.h"

namespace brume {
namespace {

constexpr int kProbesPerAxis = 16;          // pixels that are looked through, along either axis
constexpr std::size_t kMaxPhotons = 16384;  // that are looked at
constexpr std::size_t kNearest = 64;        // photons per beam whose transmittance is looked up
constexpr double kEnough = 8;               // of them, weighted, for an estimate
constexpr double kLargest = 0.05;           // of the media's diagonal
constexpr double kDefault = 0.01;           // of the scene's diagonal

/// Every n-th position of one kind of photon.
struct Sample {
  std::vector<Vec3> points;
  double perPoint = 1;  // photons given for each of these
};
Sample sampleOf(std::span<const Photon> photons, bool onSurface) {
  std::vector<Vec3> all;
  for (const Photon& photon : photons)
    if (photon.isOnSurface() == onSurface) all.push_back(photon.p);
  const std::size_t step = (all.size() + kMaxPhotons - 1) / kMaxPhotons;
  Sample sample;
  for (std::size_t i = 0; i < all.size(); i += std::max<std::size_t>(1, step))
    sample.points.push_back(all[i]);
  if (!sample.points.empty())
    sample.perPoint = static_cast<double>(all.size()) / static_cast<double>(sample.points.size());
  return sample;
}

/// Squared radius around the ray that holds `count` of the points, weighted by transmittance; from
/// the nearest ones, their number growing like the area.
std::optional<double> radius2Along(const MediumAlongRay& medium, std::span<const Vec3> points,
                                   double count, std::vector<BeamFoot<float>>& feet) {
  const Ray& ray = medium.ray();
  const Interval range = medium.occupied();
  feet.clear();
  for (const Vec3& p : points) {
    const BeamFoot<float> foot = beamFoot(ray.o, ray.d, p);
    if (foot.t >= range.t0 && foot.t <= range.t1) feet.push_back(foot);
  }
  if (feet.empty()) return std::nullopt;
  const std::size_t n = std::min(kNearest, feet.size());
  std::partial_sort(feet.begin(), feet.begin() + static_cast<std::ptrdiff_t>(n), feet.end(),
                    [](const auto& a, const auto& b) { return a.d2 < b.d2; });
  double weight = 0;
  std::size_t i = 0;
  while (i < n && weight < kEnough) weight += double{medium.transmittance(feet[i++].t).average()};
  return double{feet[i - 1].d2} * count / weight;
}

std::optional<double> median(std::vector<double>& values) {
  std::erase_if(values, [](double v) { return !(v > 0) || !std::isfinite(v); });
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The camera ray through the middle of a pixel on the grid.
FootprintRay probe(const PassContext& context, const Bounds2i& pixels, int x, int y) {
  CameraSample sample;
  sample.raster = Vec2(pixels.lo) +
                  Vec2(Vec2d(x + 0.5, y + 0.5) / double{kProbesPerAxis}) *
                      Vec2(static_cast<float>(pixels.width()), static_cast<float>(pixels.height()));
  sample.lens = Vec2(0.5f);
  sample.time = 0.5f;
  FootprintRay ray = context.camera.generateRay(sample);
  ray.differential.reset();
  return ray;
}

}  // namespace

FirstRadii firstRadii(const Scene& scene, const PassContext& context,
                      std::span<const Photon> photons, double perPhoton) {
  const Sample inMedia = sampleOf(photons, false), onSurfaces = sampleOf(photons, true);
  const PhotonKdTree surfaceTree{StridedPoints(onSurfaces.points)};
  const double beamCount = kPhotonsPerBeam / (perPhoton * inMedia.perPoint),
               pointCount = kPhotonsPerPoint / (perPhoton * onSurfaces.perPoint);

  std::vector<double> beams, points;
  std::vector<BeamFoot<float>> feet;
  MediumAlongRay medium;
  const Bounds2i pixels = context.film.sampleBounds();
  for (int y = 0; y < kProbesPerAxis; ++y)
    for (int x = 0; x < kProbesPerAxis; ++x) {
      FootprintRay ray = probe(context, pixels, x, y);
      const auto hit = scene.intersect(ray, context.stats);
      if (hit) ray.tMax = distance(ray.o, hit->p);
      if (const auto range = scene.volume() ? scene.volume()->intersect(ray) : std::nullopt) {
        medium.assign(*scene.volume(), ray, *range);
        if (const auto r2 = radius2Along(medium, inMedia.points, beamCount, feet))
          beams.push_back(*r2);
      }
      std::array<Neighbour, static_cast<std::size_t>(kEnough) + 1> found;
      if (hit && surfaceTree.nearest(hit->p, found) == found.size())
        points.push_back(double{found.front().distance2()} * pointCount / kEnough);
    }
  const double fallback = kDefault * double{length(scene.bounds().diagonal())};
  FirstRadii radii{std::sqrt(median(beams).value_or(sqr(fallback))),
                   std::sqrt(median(points).value_or(sqr(fallback)))};
  if (scene.volume())
    radii.beam =
        std::min(radii.beam, kLargest * double{length(scene.volume()->bounds().diagonal())});
  return radii;
}

}  // namespace brume
