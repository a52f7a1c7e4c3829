// SPDX-License-Identifier: Apache-2.0
// Frames: of a Bsdf, and of a bumped surface.
#include "core/material.h"

#include <gtest/gtest.h>

#include <functional>

#include "support/bsdf_checks.h"

namespace brume::test {
namespace {

/// A displacement given by a formula.
class Formula final : public Texture<float> {
 public:
  explicit Formula(std::function<float(const TextureContext&)> f) : f_(std::move(f)) {}
  float evaluate(const TextureContext& at) const override { return f_(at); }

 private:
  std::function<float(const TextureContext&)> f_;
};

/// The plane z = 0 with u along x and v along y.
SurfaceInteraction flatPoint(const Vec3& dpdu = {1, 0, 0}, const Vec3& dpdv = {0, 1, 0}) {
  SurfaceInteraction at;
  at.shading.dpdu = at.geometry.dpdu = dpdu;
  at.shading.dpdv = at.geometry.dpdv = dpdv;
  return at;
}

void expectNear(const Vec3& a, const Vec3& b, float tolerance) {
  EXPECT_LT(distance(a, b), tolerance) << a.x << " " << a.y << " " << a.z;
}

TEST(BumpFrame, FollowsASlopeInScenePosition) {
  const Formula slope([](const TextureContext& at) { return .5f * at.p.x - .25f * at.p.y; });
  const FloatSlot slot{0, &slope};
  const Vec3 expected = normalize(Vec3(-.5f, .25f, 1));
  // Differences of floats over a step of .01 carry an error of about 1e-5.
  for (const float stretch : {1.f, 20.f})
    expectNear(bumpFrame(flatPoint({stretch, 0, 0}, {0, stretch, 0}), slot).ns, expected, 1e-4f);
}

TEST(BumpFrame, FollowsASlopeInSurfaceParameters) {
  const Formula slope([](const TextureContext& at) { return 3 * at.uv.y; });
  const BumpedFrame bumped = bumpFrame(flatPoint(), {0, &slope});
  expectNear(bumped.ns, normalize(Vec3(0, -3, 1)), 1e-4f);
  expectNear(bumped.dpdu, {1, 0, 0}, 1e-6f);
}

TEST(BumpFrame, StepsByHalfTheFootprint) {
  // d = u^2 at u = 1: the difference quotient is 2 + step.
  const Formula square([](const TextureContext& at) { return at.uv.x * at.uv.x; });
  SurfaceInteraction at = flatPoint();
  at.texture.uv = {1, 0};
  const auto slopeOf = [&] { return bumpFrame(at, {0, &square}).dpdu.z; };
  EXPECT_NEAR(slopeOf(), 2.01f, 1e-4);  // without footprint the step is .01
  at.texture.dudx = -.25f;
  at.texture.dudy = .5f;
  EXPECT_NEAR(slopeOf(), 2.375f, 1e-5);
}

TEST(BumpFrame, TurnsToTheSideOfTheGeometricNormal) {
  const Formula slope([](const TextureContext& at) { return .5f * at.p.x; });
  SurfaceInteraction at = flatPoint();
  at.n = {0, 0, -1};
  EXPECT_LT(bumpFrame(at, {0, &slope}).ns.z, 0);
}

TEST(BumpFrame, ConstantDisplacementOfASphereKeepsItsNormal) {
  SurfaceInteraction at = flatPoint();
  at.shading.dndu = {.5f, 0, 0};  // radius 2
  at.shading.dndv = {0, .5f, 0};
  const BumpedFrame bumped = bumpFrame(at, {.5f, nullptr});
  expectNear(bumped.ns, {0, 0, 1}, 1e-6f);
  expectNear(bumped.dpdu, {1.25f, 0, 0}, 1e-6f);
}

TEST(BumpFrame, SurvivesASurfaceWithoutTangents) {
  const SurfaceInteraction at = flatPoint(Vec3(0), Vec3(0));
  expectNear(bumpFrame(at, {1, nullptr}).ns, {0, 0, 1}, 1e-6f);
}

/// Every texture name stands for one formula.
class OneTexture final : public TextureLookup {
 public:
  explicit OneTexture(const Texture<float>& t) : texture_(t) {}
  const Texture<float>* findFloatTexture(const std::string&) override { return &texture_; }
  const Texture<Rgb>* findRgbTexture(const std::string&) override { return nullptr; }
  std::vector<std::string> textureNames(bool) const override { return {}; }

 private:
  const Texture<float>& texture_;
};

TEST(Material, ShadesWithItsBumpMap) {
  const Formula slope([](const TextureContext& at) { return .5f * at.p.x; });
  OneTexture textures(slope);
  NamedMaterials named;
  named.add("bumped", make<Material>("matte", {texture("bumpmap", "slope")}, {}, &textures));
  named.add("flat", make<Material>("matte", {}));
  Bsdf bsdf;
  named.findMaterial("bumped")->evaluate(flatPoint(), bsdf);
  expectNear(bsdf.shadingNormal(), normalize(Vec3(-.5f, 0, 1)), 1e-4f);
  expectNear(bsdf.geometricNormal(), {0, 0, 1}, 1e-6f);
  // mix shades in the frame of its first material.
  Material::FactoryContext context;
  context.named = &named;
  const auto mixed = [&](const char* first, const char* second) {
    return make<Material>(
        "mix", {string("namedmaterial1", first), string("namedmaterial2", second)}, context);
  };
  mixed("bumped", "flat")->evaluate(flatPoint(), bsdf);
  EXPECT_LT(bsdf.shadingNormal().x, -.1f);
  mixed("flat", "bumped")->evaluate(flatPoint(), bsdf);
  expectNear(bsdf.shadingNormal(), {0, 0, 1}, 1e-6f);
}

TEST(Bsdf, FrameIsOrthonormalForAnyTangent) {
  const Vec3 n = normalize(Vec3(1, 2, 3));
  const Vec3 across = normalize(cross(n, Vec3(1, 0, 0)));
  for (const Vec3& dpdu : {across, across * 1e-20f, across * 1e20f, n + across * 1e-5f, n, Vec3(0),
                           Vec3(kInfinity, 0, 0)}) {
    Bsdf bsdf;
    bsdf.reset(n, dpdu, n);
    const Frame& f = bsdf.frame();
    for (const Vec3& axis : {f.x, f.y, f.z}) EXPECT_NEAR(length(axis), 1, 1e-6);
    EXPECT_NEAR(dot(f.x, f.y), 0, 1e-6);
    EXPECT_NEAR(dot(f.y, f.z), 0, 1e-6);
    EXPECT_NEAR(dot(f.z, f.x), 0, 1e-6);
    EXPECT_GT(dot(cross(f.x, f.y), f.z), .99f);
  }
  Bsdf bsdf;
  bsdf.reset(n, across * 7.f + n, n);
  expectNear(bsdf.frame().x, across, 1e-6f);
}

TEST(Bsdf, GeometricNormalTellsReflectionFromTransmission) {
  // The shading normal leans by 60 degrees: directions between the two horizons.
  const auto lambert = make<Material>("matte", {});
  SurfaceInteraction at = flatPoint();
  at.ns = normalize(Vec3(std::sqrt(3.f), 0, 1));
  Bsdf bsdf;
  lambert->evaluate(at, bsdf);
  const Vec3 wo = normalize(Vec3(.2f, 0, 1));
  const Vec3 belowShading = normalize(Vec3(-1, 0, .3f)), belowGround = normalize(Vec3(1, 0, -.3f));
  EXPECT_FALSE(bsdf.f(wo, belowShading).isBlack());
  EXPECT_TRUE(bsdf.f(wo, belowGround).isBlack());
  EXPECT_TRUE(bsdf.f(wo, Vec3(1, 0, 0)).isBlack());  // exactly grazing
}

TEST(Bsdf, RefusesMoreLobesThanItHolds) {
  const auto lambert = make<Material>("matte", {});
  const SurfaceInteraction at = flatPoint();
  Bsdf bsdf;
  lambert->evaluate(at, bsdf);
  for (int i = 1; i < Bsdf::kMaxLobes; ++i) lambert->addLobes(at, bsdf);
  EXPECT_THROW(lambert->addLobes(at, bsdf), InternalError);
}

}  // namespace
}  // namespace brume::test
