// SPDX-License-Identifier: Apache-2.0
#include "core/registry.h"

namespace brume {
namespace {

/// Product of two textures: tex1 tex2. Test: textures_test.
template <class T>
class ScaleTexture final : public Texture<T> {
 public:
  struct Params {
    TextureSlot<T> tex1{T{1.f}}, tex2{T{1.f}};
    void visit(ParamVisitor& v) {
      v(tex1, "tex1", kAnyFloat, Unit::None, "first factor");
      v(tex2, "tex2", kAnyFloat, Unit::None, "second factor");
    }
  };

  ScaleTexture(Params params, const TextureFactoryContext&) : params_(params) {}
  T evaluate(const TextureContext& at) const override {
    return params_.tex1.evaluate(at) * params_.tex2.evaluate(at);
  }

 private:
  Params params_;
};

constexpr const char* kSummary = "product of two textures";
const RegisterPlugin<Texture<float>, ScaleTexture<float>> kFloat{"scale", Origin::PbrtV2, kSummary};
const RegisterPlugin<Texture<Rgb>, ScaleTexture<Rgb>> kRgb{"scale", Origin::PbrtV2, kSummary};

}  // namespace
}  // namespace brume
