// SPDX-License-Identifier: Apache-2.0
#include "core/noise.h"
#include "core/registry.h"
#include "textures/mapping.h"

namespace brume {
namespace {

/// Sum of octaves of |noise|, with ridges where the noise changes its sign; no finer than the
/// footprint. Source: Perlin 1985, An Image Synthesizer. Test: textures_test.
template <class T>
class WrinkledTexture final : public Texture<T> {
 public:
  using Params = OctaveParams;

  WrinkledTexture(Params params, const TextureFactoryContext& context)
      : params_(params), mapping_(context) {}
  T evaluate(const TextureContext& at) const override {
    const TexturePoint3 q = mapping_(at);
    return T{turbulence(q.p, q.dpdx, q.dpdy, params_.roughness, params_.octaves)};
  }

 private:
  Params params_;
  Mapping3D mapping_;
};

constexpr const char* kSummary = "fractal sum of absolute noise";
const RegisterPlugin<Texture<float>, WrinkledTexture<float>> kFloat{"wrinkled", Origin::PbrtV2,
                                                                    kSummary};
const RegisterPlugin<Texture<Rgb>, WrinkledTexture<Rgb>> kRgb{"wrinkled", Origin::PbrtV2, kSummary};

}  // namespace
}  // namespace brume
