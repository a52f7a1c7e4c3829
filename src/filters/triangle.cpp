// SPDX-License-Identifier: Apache-2.0
#include "core/filter.h"
#include "core/registry.h"

namespace brume {
namespace {

/// Tent: w(x) = max(0, xwidth - |x|), and the same in y. Test: filter_test.
class TriangleFilter final : public Filter {
 public:
  struct Params {
    float xwidth = 2, ywidth = 2;

    void visit(ParamVisitor& v) {
      v(xwidth, "xwidth", kFilterRadiusRange, Unit::Pixels, "half-width");
      v(ywidth, "ywidth", kFilterRadiusRange, Unit::Pixels, "half-height");
    }
  };

  TriangleFilter(const Params& params, const FactoryContext&) : params_(params) {}

  Vec2 radius() const override { return {params_.xwidth, params_.ywidth}; }
  float weightX(float dx) const override { return std::max(0.f, params_.xwidth - std::abs(dx)); }
  float weightY(float dy) const override { return std::max(0.f, params_.ywidth - std::abs(dy)); }

 private:
  Params params_;
};

const RegisterPlugin<Filter, TriangleFilter> kRegistration{
    "triangle", Origin::PbrtV2, "tent that falls to zero at the half-width"};

}  // namespace
}  // namespace brume
