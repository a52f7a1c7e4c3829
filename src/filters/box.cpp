// SPDX-License-Identifier: Apache-2.0
#include "core/filter.h"
#include "core/registry.h"

namespace brume {
namespace {

/// All samples of the box count alike: w(x) = 1 for |x| <= xwidth. Test: filter_test.
class BoxFilter final : public Filter {
 public:
  struct Params {
    float xwidth = 0.5f, ywidth = 0.5f;

    void visit(ParamVisitor& v) {
      v(xwidth, "xwidth", kFilterRadiusRange, Unit::Pixels, "half-width");
      v(ywidth, "ywidth", kFilterRadiusRange, Unit::Pixels, "half-height");
    }
  };

  BoxFilter(const Params& params, const FactoryContext&) : params_(params) {}

  Vec2 radius() const override { return {params_.xwidth, params_.ywidth}; }
  float weightX(float) const override { return 1; }
  float weightY(float) const override { return 1; }
  bool isConstant() const override { return true; }

 private:
  Params params_;
};

const RegisterPlugin<Filter, BoxFilter> kRegistration{"box", Origin::PbrtV2,
                                                      "mean of the samples in a box"};

}  // namespace
}  // namespace brume
