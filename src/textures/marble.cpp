// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "core/noise.h"
#include "core/registry.h"
#include "textures/mapping.h"

namespace brume {
namespace {

/// Control colours of a chain of cubic Bezier curves; curve i starts at colour i, not at 3 i.
constexpr std::array<Rgb, 9> kColors{{{.58f, .58f, .6f},
                                      {.58f, .58f, .6f},
                                      {.58f, .58f, .6f},
                                      {.5f, .5f, .5f},
                                      {.6f, .59f, .58f},
                                      {.58f, .58f, .6f},
                                      {.58f, .58f, .6f},
                                      {.2f, .2f, .33f},
                                      {.58f, .58f, .6f}}};
constexpr int kCurves = static_cast<int>(kColors.size()) - 3;

/// Colour at t in [0, 1], brightened by 1.5 as in PBRT-v2.
Rgb marbleColor(float t) {
  const int first = std::min(static_cast<int>(t * kCurves), kCurves - 1);
  const float u = t * kCurves - static_cast<float>(first);
  const Rgb* c = &kColors[static_cast<std::size_t>(first)];
  const Rgb a = lerp(lerp(c[0], c[1], u), lerp(c[1], c[2], u), u);
  const Rgb b = lerp(lerp(c[1], c[2], u), lerp(c[2], c[3], u), u);
  return 1.5f * lerp(a, b, u);
}

/// Veins along y: colour((1 + sin(y + variation fbm(p))) / 2) of the scaled position. Spectrum
/// only, as in PBRT-v2. Test: textures_test.
class MarbleTexture final : public Texture<Rgb> {
 public:
  struct Params {
    OctaveParams noise;
    float scale = 1, variation = .2f;
    void visit(ParamVisitor& v) {
      noise.visit(v);
      v(scale, "scale", kAnyFloat, Unit::None, "frequency of veins and noise");
      v(variation, "variation", kAnyFloat, Unit::None, "strength of the noise");
    }
  };

  MarbleTexture(Params params, const TextureFactoryContext& context)
      : params_(params), mapping_(context) {}

  Rgb evaluate(const TextureContext& at) const override {
    const TexturePoint3 q = mapping_(at);
    const float scale = params_.scale;
    const Vec3 p = scale * q.p;
    const float wave =
        p.y + params_.variation * fbm(p, scale * q.dpdx, scale * q.dpdy, params_.noise.roughness,
                                      params_.noise.octaves);
    const float sine = std::isfinite(wave) ? std::sin(wave) : 0.f;
    return marbleColor(.5f + .5f * sine);
  }

 private:
  Params params_;
  Mapping3D mapping_;
};

const RegisterPlugin<Texture<Rgb>, MarbleTexture> kRegistration{"marble", Origin::PbrtV2,
                                                                "veins of marble along y"};

}  // namespace
}  // namespace brume
