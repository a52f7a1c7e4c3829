// SPDX-License-Identifier: Apache-2.0
#include "core/noise.h"
#include "core/registry.h"
#include "textures/mapping.h"

namespace brume {
namespace {

/// Sum of octaves of gradient noise, both signs; no finer than the footprint. Source: Perlin 1985,
/// An Image Synthesizer. Test: textures_test.
template <class T>
class FbmTexture final : public Texture<T> {
 public:
  using Params = OctaveParams;

  FbmTexture(Params params, const TextureFactoryContext& context)
      : params_(params), mapping_(context) {}
  T evaluate(const TextureContext& at) const override {
    const TexturePoint3 q = mapping_(at);
    return T{fbm(q.p, q.dpdx, q.dpdy, params_.roughness, params_.octaves)};
  }

 private:
  Params params_;
  Mapping3D mapping_;
};

constexpr const char* kSummary = "fractal sum of noise";
const RegisterPlugin<Texture<float>, FbmTexture<float>> kFloat{"fbm", Origin::PbrtV2, kSummary};
const RegisterPlugin<Texture<Rgb>, FbmTexture<Rgb>> kRgb{"fbm", Origin::PbrtV2, kSummary};

}  // namespace
}  // namespace brume
