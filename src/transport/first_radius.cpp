// SPDX-License-Identifier: Apache-2.0
#include "transport/first_radius.h"

#include <algorithm>

#include "accelerators/photon_kdtree.h"

namespace brume {
namespace {

constexpr std::size_t kNeighbours = 8;  // k of the density estimates
constexpr std::size_t kProbes = 1024;   // photons whose surroundings are looked at
constexpr double kLargest = 0.1;        // of the diagonal

/// Median squared distance from a photon to its k-th neighbour, over photons spread evenly over the
/// paths; 0 when they all coincide, none when there are too few.
std::optional<double> medianDistance2(std::span<const Photon> photons, bool onSurface) {
  std::vector<Vec3> points;
  for (const Photon& photon : photons)
    if (photon.isOnSurface() == onSurface) points.push_back(photon.p);
  if (points.size() <= kNeighbours) return std::nullopt;
  const PhotonKdTree tree{StridedPoints(points)};
  std::vector<float> distances;
  std::array<Neighbour, kNeighbours + 1> found;  // the photon itself is one
  const std::size_t step = std::max<std::size_t>(1, points.size() / kProbes);
  for (std::size_t i = 0; i < points.size(); i += step)
    if (tree.nearest(points[i], found) == found.size())
      distances.push_back(found.front().distance2());
  if (distances.empty()) return std::nullopt;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return double{*middle};
}

double atMost(double radius, const Bounds3& bounds) {
  const double largest = kLargest * double{length(bounds.diagonal())};
  return radius > 0 && radius < largest ? radius : largest;
}

}  // namespace

double firstBeamRadius(std::span<const Photon> photons, const Volume& volume, double perPhoton) {
  const Bounds3 bounds = volume.bounds();
  const auto d2 = medianDistance2(photons, false);
  if (!d2) return atMost(0, bounds);
  const Vec3d e(bounds.diagonal());
  const double chord = 2 * e.x * e.y * e.z / (e.x * e.y + e.y * e.z + e.z * e.x);
  // k photons inside the distance of the k-th, itself not counted, beside the one in the middle.
  const double density = perPhoton * (kNeighbours - 1) / (4.0 / 3 * M_PI * *d2 * std::sqrt(*d2));
  return atMost(std::sqrt(kPhotonsPerBeam / (M_PI * density * chord)), bounds);
}

double firstSurfaceRadius(std::span<const Photon> photons, const Scene& scene, double perPhoton) {
  const auto d2 = medianDistance2(photons, true);
  if (!d2) return atMost(0, scene.bounds());
  const double density = perPhoton * (kNeighbours - 1) / (M_PI * *d2);
  return atMost(std::sqrt(kPhotonsPerPoint / (M_PI * density)), scene.bounds());
}

}  // namespace brume
