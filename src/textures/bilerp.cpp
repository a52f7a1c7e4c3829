// SPDX-License-Identifier: Apache-2.0
#include "core/registry.h"
#include "textures/mapping.h"

namespace brume {
namespace {

/// Bilinear interpolation of four corner values; the first digit of vST is s. Not clamped outside
/// [0,1]^2. Test: textures_test.
template <class T>
class BilerpTexture final : public Texture<T> {
 public:
  struct Params {
    Mapping2D::Params mapping;
    T v00{0.f}, v01{1.f}, v10{0.f}, v11{1.f};
    void visit(ParamVisitor& v) {
      mapping.visit(v);
      v(v00, "v00", kAnyFloat, Unit::None, "value at s = 0, t = 0");
      v(v01, "v01", kAnyFloat, Unit::None, "value at s = 0, t = 1");
      v(v10, "v10", kAnyFloat, Unit::None, "value at s = 1, t = 0");
      v(v11, "v11", kAnyFloat, Unit::None, "value at s = 1, t = 1");
    }
  };

  BilerpTexture(Params params, const TextureFactoryContext& context)
      : mapping_(params.mapping, context), params_(params) {}
  T evaluate(const TextureContext& at) const override {
    const Vec2 st = mapping_(at).st;
    return lerp(lerp(params_.v00, params_.v01, st.y), lerp(params_.v10, params_.v11, st.y), st.x);
  }

 private:
  Mapping2D mapping_;
  Params params_;
};

constexpr const char* kSummary = "bilinear interpolation of four values";
const RegisterPlugin<Texture<float>, BilerpTexture<float>> kFloat{"bilerp", Origin::PbrtV2,
                                                                  kSummary};
const RegisterPlugin<Texture<Rgb>, BilerpTexture<Rgb>> kRgb{"bilerp", Origin::PbrtV2, kSummary};

}  // namespace
}  // namespace brume
