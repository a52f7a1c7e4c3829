// SPDX-License-Identifier: Apache-2.0
#include "core/registry.h"
#include "transport/photon_map_integrator.h"

namespace brume {
namespace {

/// Beam radiance estimate: photons blurred by a 2-D kernel perpendicular to the camera ray, all in
/// one lookup per ray.
///   Lv(o,w) ~= sum_{i: d_i < r_i} Tr(0,t_i) albedo(x_i) f_p(w_i,w) alpha_i K2(d_i; r_i)
///                                                                          [W m^-2 sr^-1]
///   t_i distance of photon i's foot along the ray, d_i its distance from it, alpha_i power [W],
///   K2 kernel [length^-2], f_p phase function [sr^-1]
/// Radii follow the photons' density (nused), or are all equal (radius). Photons behind the ray's
/// end do not count. All else as in PhotonMapIntegrator. Deposit rule: at every collision, before
/// the albedo (applied when the map is built, nowhere else). Bias O(r^2) for smooth fields; within
/// r of the end of a medium and of walls light is blurred across, O(r). Variance O(1/(N r^2)).
/// Source: Jarosz, Zwicker, Jensen 2008. Test: bre_test.
class Bre final : public PhotonMapIntegrator {
 public:
  using Params = PhotonMapParams;
  Bre(const Params& params, const FactoryContext& context)
      : PhotonMapIntegrator(params, VolumePhotonMap::Power::Scattered, context), params_(params) {}

 private:
  void onVolumeMap(const VolumePhotonMap& map) override {
    if (params_.radius)
      bvh_.emplace(map.tree(), *params_.radius);
    else
      bvh_.emplace(map.tree(), adaptiveRadii2(map.tree(), static_cast<std::size_t>(params_.nused)));
  }
  BeamEstimate estimate(const VolumePhotonMap& map, const MediumAlongRay& medium,
                        RenderContext&) const override {
    return beamRadiance(map, *bvh_, medium);
  }

  Params params_;
  std::optional<PhotonBvh> bvh_;
};

const RegisterPlugin<GlobalIntegrator, Bre> kRegistration{
    "bre", Origin::Brume,
    "beam radiance estimate: volume photon mapping with one lookup per camera ray"};

}  // namespace
}  // namespace brume
