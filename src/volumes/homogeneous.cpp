// SPDX-License-Identifier: Apache-2.0
#include "core/registry.h"
#include "volumes/box_volume.h"

namespace brume {

namespace {

/// Constant coefficients inside a box: density = 1.
///   tau = sigma_t (t1 - t0)
/// Source: PBRT-v2. Test: volumes_test.
class Homogeneous final : public BoxVolume {
 public:
  using Params = VolumeParams;
  Homogeneous(const Params& params, const FactoryContext& context) : BoxVolume(params, context) {
    checkCoefficients(context);
  }

 protected:
  double density(const Vec3d&) const override { return 1; }
  double maxDensity() const override { return 1; }
  bool isConstant() const override { return true; }
  double integral(const LocalRay&, IntervalD range) const override { return range.t1 - range.t0; }
  std::optional<double> invert(const LocalRay&, IntervalD range, double target) const override {
    if (target > range.t1 - range.t0) return std::nullopt;
    return range.t0 + target;
  }
  void appendDensity(const LocalRay&, IntervalD range,
                     std::vector<MediumPiece>& pieces) const override {
    pieces.push_back({MediumPiece::Form::Exponential, range.t0, range.t1, {1, 0}, nullptr});
  }
  double totalDensity() const override {
    const Vec3d size = boxHi() - boxLo();
    return size.x * size.y * size.z;
  }
  Vec3d sampleDensity(Rng& rng) const override {
    Vec3d p;
    for (int a = 0; a < 3; ++a) p[a] = boxLo()[a] + (boxHi()[a] - boxLo()[a]) * rng.uniformDouble();
    return p;
  }
};

const RegisterPlugin<Volume, Homogeneous> kRegistration{"homogeneous", Origin::PbrtV2,
                                                        "box of constant coefficients"};

}  // namespace

}  // namespace brume
