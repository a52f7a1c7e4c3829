// SPDX-License-Identifier: Apache-2.0
#include "core/registry.h"
#include "textures/mapping.h"

namespace brume {
namespace {

/// Whether the cell that x lies in has an odd number.
bool isOddCell(float x) {
  const float half = .5f * std::floor(x);
  return half != std::floor(half);
}

/// Integral from 0 to x of the indicator of odd cells.
float integrateOdd(float x) {
  const float period = std::floor(.5f * x);
  return period + 2 * std::max(.5f * x - period - .5f, 0.f);
}

/// Share of odd cells in [x - radius, x + radius].
float oddShare(float x, float radius) {
  if (radius == 0) return isOddCell(x) ? 1.f : 0.f;
  return (integrateOdd(x + radius) - integrateOdd(x - radius)) / (2 * radius);
}

/// Unit checks: tex1 where the sum of the cell numbers is even, tex2 where it is odd. In two
/// dimensions the mean over the box of half widths max |ds|, max |dt| is in closed form; boxes
/// wider than two checks count as half each. In three dimensions there is no filtering. Test:
/// textures_test.
template <class T>
class CheckerboardTexture final : public Texture<T> {
 public:
  enum class Antialiasing { ClosedForm, None };
  struct Params {
    int dimension = 2;
    Mapping2D::Params mapping;
    TextureSlot<T> tex1{T{1.f}}, tex2{T{0.f}};
    Antialiasing aamode = Antialiasing::ClosedForm;
    void visit(ParamVisitor& v) {
      v(dimension, "dimension", Range<int>{2, 3}, Unit::None, "checks of the plane or of space");
      mapping.visit(v);
      v(tex1, "tex1", kAnyFloat, Unit::None, "even checks");
      v(tex2, "tex2", kAnyFloat, Unit::None, "odd checks");
      v(aamode, "aamode", {{"closedform", Antialiasing::ClosedForm}, {"none", Antialiasing::None}},
        "antialiasing in two dimensions");
    }
  };

  CheckerboardTexture(Params params, const TextureFactoryContext& context)
      : params_(params), mapping2_(params.mapping, context), mapping3_(context) {}

  T evaluate(const TextureContext& at) const override {
    const float odd = params_.dimension == 3 ? solidShare(at) : planeShare(at);
    if (odd == 0) return params_.tex1.evaluate(at);
    if (odd == 1) return params_.tex2.evaluate(at);
    return lerp(params_.tex1.evaluate(at), params_.tex2.evaluate(at), odd);
  }

 private:
  float solidShare(const TextureContext& at) const {
    const Vec3 p = mapping3_(at).p;
    return (isOddCell(p.x) != isOddCell(p.y)) != isOddCell(p.z) ? 1.f : 0.f;
  }

  float planeShare(const TextureContext& at) const {
    const TexturePoint2 q = mapping2_(at);
    const float ds = std::max(std::abs(q.dstdx.x), std::abs(q.dstdy.x));
    const float dt = std::max(std::abs(q.dstdx.y), std::abs(q.dstdy.y));
    const auto inOneCell = [](float x, float radius) {
      return std::floor(x - radius) == std::floor(x + radius);
    };
    if (params_.aamode == Antialiasing::None || (inOneCell(q.st.x, ds) && inOneCell(q.st.y, dt)))
      return isOddCell(q.st.x) != isOddCell(q.st.y) ? 1.f : 0.f;
    if (!(ds <= 1 && dt <= 1)) return .5f;
    const float s = oddShare(q.st.x, ds), t = oddShare(q.st.y, dt);
    return s + t - 2 * s * t;
  }

  Params params_;
  Mapping2D mapping2_;
  Mapping3D mapping3_;
};

constexpr const char* kSummary = "checks in two or three dimensions";
const RegisterPlugin<Texture<float>, CheckerboardTexture<float>> kFloat{"checkerboard",
                                                                        Origin::PbrtV2, kSummary};
const RegisterPlugin<Texture<Rgb>, CheckerboardTexture<Rgb>> kRgb{"checkerboard", Origin::PbrtV2,
                                                                  kSummary};

}  // namespace
}  // namespace brume
