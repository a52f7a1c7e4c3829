// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/registry.h"
#include "volumes/box_volume.h"
#include "volumes/density_grid.h"
#include "volumes/slab_walk.h"

namespace brume {

namespace {

DensityGrid takeGrid(std::vector<float> density, int nx, int ny, int nz,
                     const SourceLocation& where) {
  // 93 bits at most: exact enough in double, and never multiplied in an integer before it is known
  // to fit.
  const double wanted = double(nx) * double(ny) * double(nz);
  if (wanted != static_cast<double>(density.size()))
    throw SceneError(where,
                     fmt::format("\"density\" has {} values, but nx * ny * nz = {} * {} * {} "
                                 "asks for {:.0f}",
                                 density.size(), nx, ny, nz, wanted));
  return DensityGrid(std::move(density), {nx, ny, nz});
}

/// Density sampled at the centres of nx * ny * nz voxels that fill a box, interpolated trilinearly;
/// constant in the outer half voxels, 0 outside the box.
///   density(p) = sum of the eight nearest voxels, weighted
/// Integrated exactly along rays: in a cell of eight voxel centres the density is a cubic in t (two
/// Gauss points), its integral a quartic that is inverted by bracketed Newton steps.
/// Source: PBRT-v2 for the data. Test: volumes_test, slab_walk_test.
class VolumeGrid final : public BoxVolume {
 public:
  struct Params : VolumeParams {
    int nx = 1, ny = 1, nz = 1;
    std::vector<float> density;
    void visit(ParamVisitor& v) {
      VolumeParams::visit(v);
      v(nx, "nx", kPositiveInt, Unit::None, "number of voxels along x");
      v(ny, "ny", kPositiveInt, Unit::None, "number of voxels along y");
      v(nz, "nz", kPositiveInt, Unit::None, "number of voxels along z");
      v(density, "density", kNonNegative, Unit::None,
        "nx * ny * nz densities that multiply all coefficients; x runs fastest, then y");
    }
  };

  VolumeGrid(Params params, const FactoryContext& context)
      : BoxVolume(params, context),
        grid_(takeGrid(std::move(params.density), params.nx, params.ny, params.nz, context.where)) {
    checkCoefficients(context);
    for (int a = 0; a < 3; ++a) toLattice_[a] = grid_.size()[a] / (boxHi()[a] - boxLo()[a]);
    if (isEmissive()) emission_.emplace(grid_);
  }

  bool isClosedForm() const override { return false; }

 protected:
  double density(const Vec3d& p) const override { return grid_.density(latticePoint(p)); }
  double maxDensity() const override { return double{grid_.maxDensity()}; }

  double integral(const LocalRay& ray, IntervalD range) const override {
    return integrateDensity(grid_, latticeRay(ray), range.t0, range.t1);
  }
  std::optional<double> invert(const LocalRay& ray, IntervalD range, double target) const override {
    return invertDensity(grid_, latticeRay(ray), range.t0, range.t1, target);
  }
  void appendDensity(const LocalRay& ray, IntervalD range,
                     std::vector<MediumPiece>& pieces) const override {
    appendCubics(grid_, latticeRay(ray), range.t0, range.t1, pieces);
  }

  double totalDensity() const override {
    return emission_ ? emission_->total() / (toLattice_.x * toLattice_.y * toLattice_.z) : 0;
  }
  Vec3d sampleDensity(Rng& rng) const override {
    const Vec3d p = boxLo() + (emission_->sample(grid_, rng) - Vec3d(0.5)) / toLattice_;
    return {std::clamp(p.x, boxLo().x, boxHi().x), std::clamp(p.y, boxLo().y, boxHi().y),
            std::clamp(p.z, boxLo().z, boxHi().z)};
  }

  std::optional<IntervalD> tighten(const LocalRay& ray, IntervalD range) const override {
    // The first occupied block, and the last: the first that is met from the other end.
    const DensityGrid::LatticeRay lattice = latticeRay(ray);
    std::optional<IntervalD> occupied;
    grid_.walk(lattice, range.t0, range.t1, 1, [&](const DensityGrid::Cell&, double t0, double t1) {
      occupied = IntervalD{t0, t1};
      return false;
    });
    if (occupied)
      grid_.walk({lattice.o, -lattice.d}, -range.t1, -occupied->t1, 1,
                 [&](const DensityGrid::Cell&, double t0, double) {
                   occupied->t1 = -t0;
                   return false;
                 });
    return occupied;
  }

 private:
  Vec3d latticePoint(const Vec3d& p) const { return (p - boxLo()) * toLattice_ + Vec3d(0.5); }
  DensityGrid::LatticeRay latticeRay(const LocalRay& ray) const {
    return {latticePoint(ray.o), ray.d * toLattice_};
  }

  DensityGrid grid_;
  Vec3d toLattice_;
  std::optional<DensityGrid::Sampler> emission_;  // where the medium emits
};

const RegisterPlugin<Volume, VolumeGrid> kRegistration{
    "volumegrid", Origin::PbrtV2, "density on a regular grid, interpolated trilinearly"};

}  // namespace

}  // namespace brume
