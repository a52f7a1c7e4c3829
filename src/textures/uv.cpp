// SPDX-License-Identifier: Apache-2.0
#include "core/registry.h"
#include "textures/mapping.h"

namespace brume {
namespace {

/// The texture coordinates as a colour: (frac s, frac t, 0). Spectrum only, as in PBRT-v2. Test:
/// textures_test.
class UvTexture final : public Texture<Rgb> {
 public:
  struct Params {
    Mapping2D::Params mapping;
    void visit(ParamVisitor& v) { mapping.visit(v); }
  };

  UvTexture(Params params, const TextureFactoryContext& context)
      : mapping_(params.mapping, context) {}
  Rgb evaluate(const TextureContext& at) const override {
    const Vec2 st = mapping_(at).st;
    return {st.x - std::floor(st.x), st.y - std::floor(st.y), 0};
  }

 private:
  Mapping2D mapping_;
};

const RegisterPlugin<Texture<Rgb>, UvTexture> kRegistration{"uv", Origin::PbrtV2,
                                                            "texture coordinates as a colour"};

}  // namespace
}  // namespace brume
