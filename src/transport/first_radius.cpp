// SPDX-License-Identifier: Apache-2.0
#include "transport/first_radius.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "accelerators/beam_quadtree.h"
#include "core/camera.h"
#include "core/film.h"
#include "core/medium_along_ray.h"
#include "transport/beam_radiance.h"
#include "transport/camera_beams.h"
#include "transport/surface_photon_map.h"

namespace brume {
namespace {

constexpr int kProbesPerAxis = 24;       // pixels that are looked through, along either axis
constexpr int kSteps = 16;               // of the ladder; each halves r^2
constexpr int kDown = 2;                 // steps from a radius to the one it is compared with
constexpr double kMostInPilot = 1000;    // photons of a half that the ladder begins with
constexpr double kNearlyMost = 1.5;      // times that
constexpr double kLargest = 0.1;         // of the media's diagonal
constexpr double kDefault = 0.01;        // of the scene's diagonal
constexpr double kPairsPerSegment = 50;  // of photons and beams, in the time of a path segment
constexpr double kMayHide = 2;    // standard errors of a blur that does not stand out, at most
constexpr double kStandsOut = 4;  // standard errors of one that does, at least
constexpr std::size_t kNearestPhotons = 64;  // around a point: where the surface ladder begins
constexpr std::size_t kMaxPhotons = 65536;   // that are looked at

/// The light of one half of the photons in each probed pixel, for one step of the ladder.
using PixelLight = std::vector<Rgb>;
struct Ladder {
  double largest = 0;  // radius of step 0
  std::array<std::array<PixelLight, kSteps>, 2> light;

  explicit Ladder(double r, std::size_t probes) : largest(r) {
    for (auto& half : light)
      for (PixelLight& step : half) step.resize(probes);
  }
  double radius(int step) const { return largest * std::pow(0.5, 0.5 * step); }
};

/// Follows the camera path of every probed pixel.
class Probes {
 public:
  Probes(const PassContext& context, const CameraPaths& paths) : context_(context), paths_(paths) {
    const Bounds2i pixels = context.film.sampleBounds();
    const Vec2i n{std::min(kProbesPerAxis, pixels.width()),
                  std::min(kProbesPerAxis, pixels.height())};
    for (int y = 0; y < n.y; ++y)
      for (int x = 0; x < n.x; ++x)
        pixels_.push_back(pixels.lo + Vec2i{(2 * x + 1) * pixels.width() / (2 * n.x),
                                            (2 * y + 1) * pixels.height() / (2 * n.y)});
  }
  std::size_t size() const { return pixels_.size(); }

  /// `visitor.start(i)` before each path; returns what needs no photons.
  template <class Visitor>
  PixelLight follow(Visitor& visitor) const {
    const auto sampler = context_.sampler.makePixelSampler(context_.seed);
    RenderContext render{*sampler, context_.stats};
    PixelLight light;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      sampler->startPixel(pixels_[i]);
      FootprintRay ray = context_.camera.generateRay(sampler->startSample(0));
      if (!context_.footprints) ray.differential.reset();
      visitor.start(static_cast<std::uint32_t>(i));
      light.push_back(paths_.follow(ray, visitor, render));
    }
    return light;
  }

 private:
  const PassContext& context_;
  const CameraPaths& paths_;
  std::vector<Vec2i> pixels_;
};

/// Keeps beams and visible points.
class Collector final : public CameraPathVisitor {
 public:
  void start(std::uint32_t probe) { probe_ = probe; }
  void onSegment(const MediumAlongRay& medium, const Rgb& weight, int) override {
    const Interval range = medium.range();
    beams.beams.push_back({medium.ray().o, range.t0, medium.ray().d, range.t1, 0, probe_});
    beams.owners.push_back({probe_, weight, medium.ray().time});
  }
  void onSurface(const SurfaceInteraction& at, const Bsdf&, const Rgb&) override {
    points.push_back(at.p);
  }

  OwnedBeams beams;
  std::vector<Vec3> points;

 private:
  std::uint32_t probe_ = 0;
};

/// Looks up the photons of surfaces.
class SurfaceLight final : public CameraPathVisitor {
 public:
  SurfaceLight(std::span<const SurfacePhotonMap, 2> maps, Ladder& ladder)
      : maps_(maps), ladder_(ladder) {}
  void start(std::uint32_t probe) { probe_ = probe; }
  void onSegment(const MediumAlongRay&, const Rgb&, int) override {}
  void onSurface(const SurfaceInteraction& at, const Bsdf& bsdf, const Rgb& weight) override {
    for (std::size_t half = 0; half < 2; ++half)
      for (int k = 0; k < kSteps; ++k)
        ladder_.light[half][static_cast<std::size_t>(k)][probe_] +=
            weight * maps_[half].radiance(at, bsdf, static_cast<float>(ladder_.radius(k)));
  }

 private:
  std::span<const SurfacePhotonMap, 2> maps_;
  Ladder& ladder_;
  std::uint32_t probe_ = 0;
};

/// Adds what the beams gather with one radius; returns the photons per beam.
double gatherWith(const Scene& scene, OwnedBeams& beams, double radius,
                  const VolumePhotons& photons, PixelLight& light) {
  for (Beam& beam : beams.beams) beam.radius = static_cast<float>(radius);
  const BeamQuadtree tree = BeamQuadtree::inSpace(beams.beams);
  const std::vector<BeamSum> sums = gatherBeams(*scene.volume(), beams, tree, photons);
  double pairs = 0;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const BeamSum& sum = sums[i];
    const Rgb L(static_cast<float>(sum.r), static_cast<float>(sum.g), static_cast<float>(sum.b));
    light[beams.owners[i].sample] += beams.owners[i].weight * L;
    pairs += static_cast<double>(sum.count);
  }
  return pairs / static_cast<double>(sums.size());
}

/// Variance of a half and squared blur at one radius. Weights make both relative to the brightness
/// of pixels.
struct Balance {
  double radius = 0, variance = 0, blur2 = 0;
};

/// Mean and its standard error.
struct Mean {
  double sum = 0, squares = 0;
  std::size_t n = 0;
  void add(double x) { sum += x, squares += x * x, ++n; }
  double mean() const { return sum / static_cast<double>(n); }
  double error() const {
    return std::sqrt(std::max(0., squares / static_cast<double>(n) - sqr(mean())) /
                     static_cast<double>(n));
  }
};

std::optional<Balance> balanceOf(const Ladder& ladder, std::span<const double> weights) {
  std::optional<Balance> found;
  const double gap2 = sqr(1 - std::pow(0.5, kDown));
  for (int k = 0; k + kDown < kSteps; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const auto &A = ladder.light[0][at], &B = ladder.light[1][at];
    const auto &As = ladder.light[0][at + kDown], &Bs = ladder.light[1][at + kDown];
    Mean variance, blur;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      double dAB = 0, product = 0;
      for (int c = 0; c < 3; ++c) {
        dAB += sqr(double{A[i][c]} - double{B[i][c]});
        product += (double{A[i][c]} - double{As[i][c]}) * (double{B[i][c]} - double{Bs[i][c]});
      }
      variance.add(weights[i] * dAB / 6);
      blur.add(weights[i] * product / (3 * gap2));
    }
    if (!(variance.mean() > 0)) continue;
    const bool standsOut = blur.mean() > kStandsOut * blur.error();
    if (found && !standsOut) break;
    const double b2 = standsOut ? blur.mean() : std::max(0., blur.mean()) + kMayHide * blur.error();
    found = Balance{ladder.radius(k), variance.mean(), b2};
    if (!standsOut) break;
  }
  return found;
}

/// Two halves of a pilot's photons by the order of their paths, each as if it were all; of many,
/// every n-th.
struct Halves {
  std::array<std::vector<Photon>, 2> photons;
  double paths = 0;  // of a half

  explicit Halves(const PhotonSet& pilot) {
    const std::size_t n = pilot.photons.size(), step = n / kMaxPhotons + 1, half = (n / step) / 2;
    if (half == 0) return;
    const double share = static_cast<double>(half) / static_cast<double>(n);
    for (std::size_t i = 0; i < 2 * half; ++i) {
      Photon photon = pilot.photons[i * step];
      photon.power /= static_cast<float>(share);
      photons[i / half].push_back(photon);
    }
    paths = share * static_cast<double>(*std::max_element(pilot.paths.begin(), pilot.paths.end()));
  }
  /// Diagonal of the box around the photons in media.
  double extent() const {
    Bounds3 bounds;
    for (const auto& half : photons)
      for (const Photon& photon : half)
        if (!photon.isOnSurface()) bounds.extend(photon.p);
    return bounds.isEmpty() ? 0 : double{length(bounds.diagonal())};
  }
};

std::optional<double> median(std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The radius that holds kNearestPhotons around a visible point.
std::optional<double> surfaceReach(const SurfacePhotonMap& map, std::span<const Vec3> points) {
  std::vector<double> reach;
  std::array<Neighbour, kNearestPhotons> found;
  for (const Vec3& p : points)
    if (map.tree().nearest(p, found) == found.size())
      reach.push_back(double{found.front().distance2()});
  const auto middle = median(reach);
  return middle ? std::optional(std::sqrt(*middle)) : std::nullopt;
}

/// Relative to the brightness of each pixel, as Film::estimatedRelativeError.
std::vector<double> weightsOf(const PixelLight& light) {
  double mean = 0;
  for (const Rgb& L : light) mean += double{L.average()} / static_cast<double>(light.size());
  std::vector<double> weights;
  for (const Rgb& L : light) {
    const double square = sqr(double{L.average()}) + kDarkShare * sqr(mean);
    weights.push_back(square > 0 ? 1 / square : 0);
  }
  return weights;
}

}  // namespace

FirstRadii firstRadii(const Scene& scene, const CameraPaths& paths, const PassContext& context,
                      const PhotonSet& pilot, const PassCost& pass) {
  const double fallback = kDefault * double{length(scene.bounds().diagonal())};
  FirstRadii radii;
  radii.beam = radii.surface = fallback;
  const Halves halves(pilot);
  const Probes probes(context, paths);
  Collector seen;
  PixelLight all = probes.follow(seen);

  std::optional<Ladder> beams, surfaces;
  double mostPerBeam = 0;  // photons of a half at the largest radius
  if (!seen.beams.beams.empty()) {
    const VolumePhotons photons[] = {{*scene.volume(), halves.photons[0]},
                                     {*scene.volume(), halves.photons[1]}};
    // Where the light fills but a small part of the media, many times smaller than they are.
    double largest = kLargest * double{length(scene.volume()->bounds().diagonal())};
    if (const double extent = halves.extent(); extent > 0)
      largest = std::min(largest, 2 * kLargest * extent);
    PixelLight scratch(probes.size());
    const auto count = [&] { return gatherWith(scene, seen.beams, largest, photons[0], scratch); };
    mostPerBeam = count();
    // Photons per beam fall like r^2, or more slowly while a beam holds nearly all there are.
    while (mostPerBeam > kMostInPilot) {
      largest *= std::sqrt(kMostInPilot / mostPerBeam);
      mostPerBeam = count();
      if (mostPerBeam < kNearlyMost * kMostInPilot) break;
    }
    beams.emplace(largest, probes.size());
    for (std::size_t half = 0; half < 2; ++half)
      for (int k = 0; k < kSteps; ++k)
        gatherWith(scene, seen.beams, beams->radius(k), photons[half],
                   beams->light[half][static_cast<std::size_t>(k)]);
  }
  const Accelerator* accelerator = &scene.accelerator();
  const SurfacePhotonMap maps[] = {
      SurfacePhotonMap(std::span<const Photon>(halves.photons[0]), accelerator),
      SurfacePhotonMap(std::span<const Photon>(halves.photons[1]), accelerator)};
  if (const auto reach = surfaceReach(maps[0], seen.points)) {
    surfaces.emplace(*reach, probes.size());
    SurfaceLight lookup(maps, *surfaces);
    probes.follow(lookup);
  }
  for (const auto& ladder : {&beams, &surfaces})
    if (*ladder)
      for (std::size_t i = 0; i < all.size(); ++i)
        all[i] += 0.5f * ((**ladder).light[0][0][i] + (**ladder).light[1][0][i]);
  const std::vector<double> weights = weightsOf(all);

  struct Best {
    double radius = 0;
    double variance = 0;  ///< of a pass with radius 1
  };
  const auto best = [&](const std::optional<Ladder>& ladder) -> std::optional<Best> {
    const auto balance = ladder ? balanceOf(*ladder, weights) : std::nullopt;
    if (!balance || !(balance->blur2 > 0)) return std::nullopt;
    // 3/4 V x^-2 = kNoiseOverBlur 16/9 b^2 x^3, x in radii of the balance.
    const double variance = balance->variance * halves.paths / kUsualPaths;
    const double x = std::pow(0.75 * variance / (kNoiseOverBlur * 16 / 9 * balance->blur2), 0.2);
    return Best{x * balance->radius * std::pow(kUsualPaths / pass.paths, 1. / 6),
                balance->variance * halves.paths / pass.paths * sqr(balance->radius)};
  };
  if (const auto found = best(beams)) {
    // Photons per beam of a pass, at the largest radius and as many as cost no more than tracing.
    const double atLargest = std::max(mostPerBeam, 1e-3) * pass.paths / halves.paths;
    const double beamsOfPass = static_cast<double>(context.film.sampleBounds().area()) *
                               static_cast<double>(seen.beams.beams.size()) /
                               static_cast<double>(probes.size());
    const double most = std::max(kAlwaysPerBeam, kPairsPerSegment * pass.segments / beamsOfPass);
    const double affordable = beams->largest * std::sqrt(most / atLargest);
    radii.beam = std::min({found->radius, affordable,
                           kLargest * double{length(scene.volume()->bounds().diagonal())}});
    radii.beamVariance = found->variance / sqr(radii.beam);
    for (Beam& beam : seen.beams.beams) beam.radius = static_cast<float>(radii.beam);
    radii.beamReach = reachOf(seen.beams.beams);
  }
  if (const auto found = best(surfaces)) {
    radii.surface = found->radius;
    radii.surfaceVariance = found->variance / sqr(radii.surface);
    const Vec3 around(static_cast<float>(radii.surface));
    for (const Vec3& p : seen.points) radii.surfaceReach.extend(Bounds3{p - around, p + around});
  }
  return radii;
}

}  // namespace brume
