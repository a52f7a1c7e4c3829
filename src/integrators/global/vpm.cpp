// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/registry.h"
#include "transport/free_flight.h"
#include "transport/photon_map_integrator.h"

namespace brume {
namespace {

/// Of the media's diagonal: the step where none is given. At most so much of the photons' root mean
/// square distance from their middle, where they fill a small part of the media.
constexpr float kDefaultStep = 0.01f, kDefaultStepOfSpread = 0.08f;
/// Default steps grow, each twice as long as the one before, where less than this transmittance or
/// so many steps are left behind.
constexpr float kDeepTransmittance = 1e-4f;
constexpr int kEvenSteps = 1000;
/// Of a given size, through the whole diagonal: more would be a slip, and take hours.
constexpr float kMostSteps = 1e5f;

/// Root mean square distance of the photons from their middle.
float spreadOf(const PhotonKdTree& tree) {
  Vec3d sum(0);
  double squares = 0;
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Vec3d p(tree.point(i));
    sum += p;
    squares += dot(p, p);
  }
  const auto n = static_cast<double>(tree.size());
  return static_cast<float>(std::sqrt(std::max(0., squares / n - dot(sum, sum) / (n * n))));
}

/// Volume photon mapping: marches along the camera ray and asks at every step for the photons
/// around a point.
///   Lv(o,w) ~= sum_j dt_j Tr(0,t_j) albedo(x_j) sum_{i in N(x_j)} f_p alpha_i K3(|x_i - x_j|; r_j)
///                                                                          [W m^-2 sr^-1]
///   t_j the same random place in each step of a ray, dt_j the step, alpha_i photon power [W],
///   K3 kernel [length^-3], f_p(w_i,w) phase function [sr^-1]
/// N(x_j): the nused nearest, of which the farthest sets r_j and does not count itself; or all
/// within `radius`. The march itself has no bias, whatever the step. All else as in
/// PhotonMapIntegrator. Deposit rule: at every collision, before the albedo (applied at x_j,
/// nowhere else). Bias O(r^2) for smooth fields, O(r) within r of faces and walls that slant to the
/// ray; variance O(1/(N r^2 max(r, step))). Source: Jensen, Christensen 1998, Efficient Simulation
/// of Light Transport in Scenes with Participating Media using Photon Maps. Test: vpm_test.
class Vpm final : public PhotonMapIntegrator {
 public:
  struct Params : PhotonMapParams {
    std::optional<float> stepsize;
    void visit(ParamVisitor& v) {
      PhotonMapParams::visit(v);
      v(stepsize, "stepsize", kPositive, Unit::Length,
        "of the march; by default a hundredth of the media's diagonal, or less where the light "
        "fills a small part of them");
    }
  };
  Vpm(const Params& params, const FactoryContext& context)
      : PhotonMapIntegrator(params, VolumePhotonMap::Power::Arriving, context),
        params_(params),
        where_(context.where) {}

 private:
  void onVolumeMap(const VolumePhotonMap& map) override {
    const float diagonal = 2 * map.volume().bounds().radius();
    step_ = params_.stepsize.value_or(
        std::min(kDefaultStep * diagonal, kDefaultStepOfSpread * spreadOf(map.tree())));
    if (params_.stepsize && diagonal > kMostSteps * step_)
      throw SceneError(where_,
                       fmt::format("\"stepsize\" {} would take {:.3g} steps through the media "
                                   "of diagonal {}; at most {} are allowed",
                                   step_, diagonal / step_, diagonal, kMostSteps));
    if (params_.radius)
      lookup_.radius = *params_.radius;
    else
      lookup_.nearest = static_cast<std::size_t>(params_.nused);
  }

  BeamEstimate estimate(const VolumePhotonMap& map, const MediumAlongRay& medium,
                        RenderContext& context) const override {
    thread_local BallSearch search;  // reused, so that its memory is
    // Photons beyond the ends of the ray or of the medium do not count.
    const Interval range = medium.occupied();
    PointLookup lookup = lookup_;
    // Whole steps, none longer than asked for.
    double dt = double{range.length()} / std::ceil(double{range.length()} / double{step_});
    const double offset = double{context.samples.get1D()}, rangeEnd = double{range.t1};
    BeamEstimate sum;
    double start = double{range.t0};
    for (int steps = 1; start < rangeEnd; ++steps) {
      double end = start + dt;
      if (!(end + 0.5 * dt < rangeEnd)) end = rangeEnd;
      const auto t = static_cast<float>(start + offset * (end - start));
      const Rgb Tr = medium.transmittance(t), scattered = Tr * albedoOf(medium.at(t));
      if (!scattered.isBlack()) {
        lookup.between = {range.t0 - t, range.t1 - t};
        const BeamEstimate here =
            pointRadiance(map, lookup, medium.ray()(t), -medium.ray().d, search);
        sum.L += scattered * here.L * static_cast<float>(end - start);
        sum.photons += here.photons;
      }
      // There is little to see behind this.
      if (!params_.stepsize && (steps >= kEvenSteps || Tr.maxChannel() < kDeepTransmittance))
        dt *= 2;
      start = end;
    }
    return sum;
  }

  Params params_;
  SourceLocation where_;
  float step_ = 1;
  PointLookup lookup_;
};

const RegisterPlugin<GlobalIntegrator, Vpm> kRegistration{
    "vpm", Origin::Brume,
    "volume photon mapping: marches through the media, photons around a point"};

}  // namespace
}  // namespace brume
