// SPDX-License-Identifier: Apache-2.0
#include "core/registry.h"

namespace brume {
namespace {

/// Linear mixture (1 - amount) tex1 + amount tex2; the amount is not clamped. Test: textures_test.
template <class T>
class MixTexture final : public Texture<T> {
 public:
  struct Params {
    TextureSlot<T> tex1{T{0.f}}, tex2{T{1.f}};
    FloatSlot amount{.5f};
    void visit(ParamVisitor& v) {
      v(tex1, "tex1", kAnyFloat, Unit::None, "result for amount 0");
      v(tex2, "tex2", kAnyFloat, Unit::None, "result for amount 1");
      v(amount, "amount", kAnyFloat, Unit::None, "share of tex2");
    }
  };

  MixTexture(Params params, const TextureFactoryContext&) : params_(params) {}
  T evaluate(const TextureContext& at) const override {
    return lerp(params_.tex1.evaluate(at), params_.tex2.evaluate(at), params_.amount.evaluate(at));
  }

 private:
  Params params_;
};

constexpr const char* kSummary = "linear mixture of two textures";
const RegisterPlugin<Texture<float>, MixTexture<float>> kFloat{"mix", Origin::PbrtV2, kSummary};
const RegisterPlugin<Texture<Rgb>, MixTexture<Rgb>> kRgb{"mix", Origin::PbrtV2, kSummary};

}  // namespace
}  // namespace brume
