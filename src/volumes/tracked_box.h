// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "volumes/box_volume.h"
#include "volumes/gradient_noise.h"

namespace brume {

/// A medium in a box whose density can be evaluated and bounded, but not integrated
/// (Volume::isTracked). The box is cut into cells, each with a density that nothing in it exceeds;
/// a ray's tentative collisions are a Poisson process with the rate
///   mu = (cell's bound) max_c sigma_t,c                                        [1/length]
/// cell by cell, and none in empty cells. At each the optical depth of channel c grows by
///   -log(1 - sigma_t,c density / mu).
/// Random numbers: keyed by the ray's bits, trackingKey() and where the volume stands in its file.
/// Behind an optical depth of 40 in all channels that have any nothing is drawn any more.
/// Source: Woodcock 1965; Novak, Selle, Jarosz 2014 (ratio tracking). Test: cloud_test.
class TrackedBox : public BoxVolume {
 public:
  using BoxVolume::BoxVolume;

  Rgb opticalDepth(const Ray& ray, Interval range) const final;
  std::optional<float> invertOpticalDepth(const Ray& ray, Interval range, int channel,
                                          float depth) const final;
  void appendPieces(const Ray& ray, Interval range, std::vector<MediumPiece>& pieces) const final;
  bool isClosedForm() const final { return false; }
  bool isTracked() const final { return true; }
  double densityAt(const Ray& ray, double t) const final;

 protected:
  /// Called once by the constructor of the derived class: cells of about this size, at most 64
  /// along an axis. `where` keys the random numbers.
  void buildCells(double cellSize, const SourceLocation& where);
  /// No density in the box, a part of the volume's, is larger.
  virtual double upperBound(const Bounds3d& box) const = 0;

  double maxDensity() const final { return maxDensity_; }
  /// Bound of the cell that holds p.
  double boundAt(const Vec3d& p) const { return bounds_[index(cellOf(p))]; }

 private:
  using Cell = std::array<int, 3>;
  struct Walk;
  Cell cellOf(const Vec3d& p) const;
  std::size_t index(const Cell& c) const {
    return (static_cast<std::size_t>(c[2]) * cells_[1] + c[1]) * cells_[0] + c[0];
  }
  Bounds3d boxOf(const Cell& c) const;
  template <class Collision>
  void track(const Ray& ray, Interval range, Collision&& collide) const;

  double integral(const LocalRay&, IntervalD) const final;
  std::optional<double> invert(const LocalRay&, IntervalD, double) const final;
  void appendDensity(const LocalRay&, IntervalD, std::vector<MediumPiece>&) const final;
  double totalDensity() const final;
  Vec3d sampleDensity(Rng&) const final;

  Cell cells_{1, 1, 1};
  Vec3d cellSize_{1};
  std::vector<float> bounds_;  // x fastest
  double maxDensity_ = 0;
  std::uint64_t salt_ = 0;
};

}  // namespace brume
