// SPDX-License-Identifier: Apache-2.0
#include "core/noise.h"
#include "core/registry.h"
#include "textures/mapping.h"

namespace brume {
namespace {

/// Waves on water under gusts: |fbm(p/10)| fbm(p), meant for bump maps. Test: textures_test.
template <class T>
class WindyTexture final : public Texture<T> {
 public:
  struct Params {
    void visit(ParamVisitor&) {}
  };

  WindyTexture(Params, const TextureFactoryContext& context) : mapping_(context) {}
  T evaluate(const TextureContext& at) const override {
    const TexturePoint3 q = mapping_(at);
    const float wind = fbm(.1f * q.p, .1f * q.dpdx, .1f * q.dpdy, .5f, 3);
    const float waves = fbm(q.p, q.dpdx, q.dpdy, .5f, 6);
    return T{std::abs(wind) * waves};
  }

 private:
  Mapping3D mapping_;
};

constexpr const char* kSummary = "waves under gusts of wind";
const RegisterPlugin<Texture<float>, WindyTexture<float>> kFloat{"windy", Origin::PbrtV2, kSummary};
const RegisterPlugin<Texture<Rgb>, WindyTexture<Rgb>> kRgb{"windy", Origin::PbrtV2, kSummary};

}  // namespace
}  // namespace brume
