// SPDX-License-Identifier: Apache-2.0
#include "core/registry.h"

namespace brume {
namespace {

/// The same value everywhere. Test: textures_test.
template <class T>
class ConstantTexture final : public Texture<T> {
 public:
  struct Params {
    T value{1.f};
    void visit(ParamVisitor& v) { v(value, "value", kAnyFloat, Unit::None, "the value"); }
  };

  ConstantTexture(Params params, const TextureFactoryContext&) : value_(params.value) {}
  T evaluate(const TextureContext&) const override { return value_; }

 private:
  T value_;
};

constexpr const char* kSummary = "one value everywhere";
const RegisterPlugin<Texture<float>, ConstantTexture<float>> kFloat{"constant", Origin::PbrtV2,
                                                                    kSummary};
const RegisterPlugin<Texture<Rgb>, ConstantTexture<Rgb>> kRgb{"constant", Origin::PbrtV2, kSummary};

}  // namespace
}  // namespace brume
