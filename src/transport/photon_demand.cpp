// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_demand.h"

#include <algorithm>
#include <cmath>

#include "accelerators/photon_kdtree.h"
#include "core/camera.h"
#include "core/lowdiscrepancy.h"
#include "core/medium_along_ray.h"
#include "transport/camera_path.h"
#include "transport/photon_sources.h"

namespace brume {
namespace {

constexpr int kPixelsPerAxis = 16;    // that are looked through
constexpr std::size_t kNearest = 50;  // photons of a lookup
constexpr std::size_t kFewest = 8;    // from which a lookup tells anything

/// A place before it is known what is found there.
struct Seen {
  Vec3 p;
  float weight;  ///< of its light in the pixel
};

class Collector final : public CameraPathVisitor {
 public:
  void start(std::uint32_t pixel) { u_ = shiftedRadicalInverse(2, pixel, 0); }
  void onSegment(const MediumAlongRay& medium, const Rgb& weight, int) override {
    const Rgb scattered = Rgb(1.f) - medium.transmittance();
    const int channel = scattered.r >= scattered.g && scattered.r >= scattered.b ? 0
                        : scattered.g >= scattered.b                             ? 1
                                                                                 : 2;
    const float share = scattered[channel];
    if (!(share > 0)) return;
    if (const auto t = medium.invert(channel, -std::log1p(-double{u_} * double{share})))
      inMedia.push_back({medium.ray()(static_cast<float>(*t)), weight.average() * share});
  }
  void onSurface(const SurfaceInteraction& at, const Bsdf&, const Rgb& weight) override {
    onSurfaces.push_back({at.p, weight.average()});
  }

  std::vector<Seen> inMedia, onSurfaces;

 private:
  float u_ = 0;
};

void followPaths(const Scene& scene, const ImageView& view, std::uint64_t seed, Stats& stats,
                 Collector& collector) {
  const CameraPaths paths(scene, {16, false, false});
  const auto sampler = view.sampler.makePixelSampler(seed);
  RenderContext render{*sampler, stats};
  const Bounds2i& pixels = view.pixels;
  const Vec2i n{std::min(kPixelsPerAxis, pixels.width()),
                std::min(kPixelsPerAxis, pixels.height())};
  for (int y = 0; y < n.y; ++y)
    for (int x = 0; x < n.x; ++x) {
      sampler->startPixel(pixels.lo + Vec2i{(2 * x + 1) * pixels.width() / (2 * n.x),
                                            (2 * y + 1) * pixels.height() / (2 * n.y)});
      FootprintRay ray = view.camera.generateRay(sampler->startSample(0));
      ray.differential.reset();
      collector.start(static_cast<std::uint32_t>(y * n.x + x));
      paths.follow(ray, collector, render);
    }
}

}  // namespace

PhotonDemand::PhotonDemand(const Scene& scene, const ImageView& view, std::span<const Photon> pilot,
                           std::uint64_t seed, Stats& stats) {
  Collector collector;
  followPaths(scene, view, seed, stats, collector);
  std::array<std::vector<Photon>, 2> photons;
  for (const Photon& photon : pilot) photons[kindOf(photon)].push_back(photon);

  std::vector<Neighbour> nearest(kNearest);
  for (std::size_t kind = 0; kind < 2; ++kind) {
    const std::vector<Photon>& all = photons[kind];
    if (all.size() < kFewest) continue;
    const PhotonKdTree tree(StridedPoints(&all.front().p, all.size(), sizeof(Photon)));
    for (const Seen& seen : kind == 0 ? collector.inMedia : collector.onSurfaces) {
      const std::size_t count = tree.nearest(seen.p, nearest);
      double sum = 0;
      float radius2 = 0;
      for (std::size_t i = 0; i < count; ++i) {
        sum += double{largestChannel(all[tree.order()[nearest[i].index()]].power)};
        radius2 = std::max(radius2, nearest[i].distance2());
      }
      const double weight = sum > 0 ? sqr(double{seen.weight} / sum) : 0;
      if (weight > 0 && std::isfinite(static_cast<float>(weight)))
        places_[kind].push_back({seen.p, radius2, static_cast<float>(weight)});
    }
  }
}

double PhotonDemand::squareOf(std::span<const Photon> photons) const {
  double sum = 0;
  for (const Photon& photon : photons) {
    float weight = 0;
    for (const Place& place : places_[kindOf(photon)]) {
      const Vec3 d = photon.p - place.p;
      weight += dot(d, d) <= place.radius2 ? place.weight : 0.f;
    }
    sum += sqr(double{largestChannel(photon.power)}) * double{weight};
  }
  return sum;
}

}  // namespace brume
