// SPDX-License-Identifier: Apache-2.0
#include "core/filter.h"
#include "core/registry.h"

namespace brume {
namespace {

/// The cubic of Mitchell and Netravali 1988 on x / xwidth, stretched from its own support [-2, 2];
/// negative lobes when C > 0. B + 2C = 1 gives the sharpest without ringing. Test: filter_test.
class MitchellFilter final : public Filter {
 public:
  struct Params {
    float xwidth = 2, ywidth = 2;
    float B = 1.f / 3, C = 1.f / 3;

    void visit(ParamVisitor& v) {
      v(xwidth, "xwidth", kFilterRadiusRange, Unit::Pixels, "half-width");
      v(ywidth, "ywidth", kFilterRadiusRange, Unit::Pixels, "half-height");
      v(B, "B", kAnyFloat, Unit::None, "blur");
      v(C, "C", kAnyFloat, Unit::None, "ringing");
    }
  };

  MitchellFilter(const Params& params, const FactoryContext&) : params_(params) {}

  Vec2 radius() const override { return {params_.xwidth, params_.ywidth}; }
  float weightX(float dx) const override { return cubic(dx / params_.xwidth); }
  float weightY(float dy) const override { return cubic(dy / params_.ywidth); }

 private:
  /// For t in [-1, 1].
  float cubic(float t) const {
    const float B = params_.B, C = params_.C, x = std::abs(2 * t);
    if (x >= 2) return 0;
    if (x > 1)
      return (((-B - 6 * C) * x + (6 * B + 30 * C)) * x + (-12 * B - 48 * C)) * x / 6 +
             (8 * B + 24 * C) / 6;
    return ((12 - 9 * B - 6 * C) * x + (-18 + 12 * B + 6 * C)) * x * x / 6 + (6 - 2 * B) / 6;
  }

  Params params_;
};

const RegisterPlugin<Filter, MitchellFilter> kRegistration{
    "mitchell", Origin::PbrtV2, "cubic with negative lobes (Mitchell, Netravali)"};

}  // namespace
}  // namespace brume
