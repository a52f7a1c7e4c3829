// SPDX-License-Identifier: Apache-2.0
#include "core/filter.h"
#include "core/registry.h"

namespace brume {
namespace {

/// Gaussian moved down to reach zero at its border:
///   w(x) = max(0, exp(-alpha x^2) - exp(-alpha xwidth^2)), and the same in y. Test: filter_test.
class GaussianFilter final : public Filter {
 public:
  struct Params {
    float xwidth = 2, ywidth = 2;
    float alpha = 2;

    void visit(ParamVisitor& v) {
      v(xwidth, "xwidth", kFilterRadiusRange, Unit::Pixels, "half-width");
      v(ywidth, "ywidth", kFilterRadiusRange, Unit::Pixels, "half-height");
      v(alpha, "alpha", kPositive, Unit::None, "falloff [pixels^-2]: larger is sharper");
    }
  };

  GaussianFilter(const Params& params, const FactoryContext&)
      : params_(params),
        edgeX_(std::exp(-params.alpha * sqr(params.xwidth))),
        edgeY_(std::exp(-params.alpha * sqr(params.ywidth))) {}

  Vec2 radius() const override { return {params_.xwidth, params_.ywidth}; }
  float weightX(float dx) const override { return falloff(dx, edgeX_); }
  float weightY(float dy) const override { return falloff(dy, edgeY_); }

 private:
  float falloff(float d, float edge) const {
    return std::max(0.f, std::exp(-params_.alpha * d * d) - edge);
  }

  Params params_;
  float edgeX_, edgeY_;  // the Gaussian at the border
};

const RegisterPlugin<Filter, GaussianFilter> kRegistration{"gaussian", Origin::PbrtV2,
                                                           "Gaussian, zero at its border"};

}  // namespace
}  // namespace brume
