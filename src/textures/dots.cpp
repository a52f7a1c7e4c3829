// SPDX-License-Identifier: Apache-2.0
#include "core/noise.h"
#include "core/registry.h"
#include "textures/mapping.h"

namespace brume {
namespace {

constexpr float kRadius = .35f;
constexpr float kMaxShift = .5f - kRadius;

float noise2(float s, float t) { return noise({s, t, .5f}); }

/// Round dots of radius 0.35 in about half of the unit cells, moved at random. PBRT-v2 exchanges
/// the two textures, and scenes were authored with it: "inside" is what lies outside the dots.
/// Test: textures_test.
template <class T>
class DotsTexture final : public Texture<T> {
 public:
  struct Params {
    Mapping2D::Params mapping;
    TextureSlot<T> inside{T{1.f}}, outside{T{0.f}};
    void visit(ParamVisitor& v) {
      mapping.visit(v);
      v(inside, "inside", kAnyFloat, Unit::None, "outside the dots (exchanged, as in PBRT-v2)");
      v(outside, "outside", kAnyFloat, Unit::None, "inside the dots (exchanged, as in PBRT-v2)");
    }
  };

  DotsTexture(Params params, const TextureFactoryContext& context)
      : params_(params), mapping_(params.mapping, context) {}

  T evaluate(const TextureContext& at) const override {
    return isInDot(mapping_(at).st) ? params_.outside.evaluate(at) : params_.inside.evaluate(at);
  }

 private:
  static bool isInDot(Vec2 st) {
    const float s = std::floor(st.x + .5f), t = std::floor(st.y + .5f);
    if (!(noise2(s + .5f, t + .5f) > 0)) return false;
    const Vec2 shift(noise2(s + 1.5f, t + 2.8f), noise2(s + 4.5f, t + 9.8f));
    const Vec2 d = st - (Vec2(s, t) + kMaxShift * shift);
    return dot(d, d) < kRadius * kRadius;
  }

  Params params_;
  Mapping2D mapping_;
};

constexpr const char* kSummary = "round dots at random places";
const RegisterPlugin<Texture<float>, DotsTexture<float>> kFloat{"dots", Origin::PbrtV2, kSummary};
const RegisterPlugin<Texture<Rgb>, DotsTexture<Rgb>> kRgb{"dots", Origin::PbrtV2, kSummary};

}  // namespace
}  // namespace brume
