// SPDX-License-Identifier: Apache-2.0
#include "core/filter.h"
#include "core/registry.h"

namespace brume {
namespace {

/// Lanczos-windowed sinc on t = x / xwidth:
///   w(x) = sinc(t) sinc(tau t), sinc(t) = sin(pi t) / (pi t), 0 for |t| > 1
/// The window is the wide factor, so tau counts the cycles within the half-width. Test:
/// filter_test.
class SincFilter final : public Filter {
 public:
  struct Params {
    float xwidth = 4, ywidth = 4;
    float tau = 3;

    void visit(ParamVisitor& v) {
      v(xwidth, "xwidth", kFilterRadiusRange, Unit::Pixels, "half-width");
      v(ywidth, "ywidth", kFilterRadiusRange, Unit::Pixels, "half-height");
      v(tau, "tau", kPositive, Unit::None, "number of half-waves within the half-width");
    }
  };

  SincFilter(const Params& params, const FactoryContext&) : params_(params) {}

  Vec2 radius() const override { return {params_.xwidth, params_.ywidth}; }
  float weightX(float dx) const override { return lanczos(dx / params_.xwidth); }
  float weightY(float dy) const override { return lanczos(dy / params_.ywidth); }

 private:
  static float sinc(float t) {
    const float x = kPi * std::abs(t);
    return x < 1e-4f ? 1.f : std::sin(x) / x;  // 1 - x^2/6 rounds to 1
  }
  float lanczos(float t) const { return std::abs(t) >= 1 ? 0.f : sinc(t) * sinc(params_.tau * t); }

  Params params_;
};

const RegisterPlugin<Filter, SincFilter> kRegistration{"sinc", Origin::PbrtV2,
                                                       "Lanczos-windowed sinc"};

}  // namespace
}  // namespace brume
