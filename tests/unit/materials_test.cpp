// SPDX-License-Identifier: Apache-2.0
// Every material: what holds for all of them. Closed forms of each are in material_forms_test.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/rng.h"
#include "core/sampling.h"
#include "support/bsdf_checks.h"

namespace brume::test {
namespace {

struct Case {
  const char* label;
  const char* material;
  std::vector<Param> params;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.label; }

/// Two materials to mix.
NamedMaterials& mixable() {
  static NamedMaterials named;
  if (named.materialNames().empty()) {
    named.add("rough", make<Material>("plastic", {color("Kd", {.3f, .5f, .1f})}));
    named.add("thin", make<Material>("translucent", {floats("roughness", {.3f})}));
  }
  return named;
}

std::unique_ptr<Material> makeCase(const Case& c) {
  Material::FactoryContext context;
  context.named = &mixable();
  return make<Material>(c.material, c.params, context);
}

std::vector<Case> allCases() {
  return {
      {"matte", "matte", {}},
      {"matteWhite", "matte", {color("Kd", Rgb(1.f))}},
      {"oren30", "matte", {color("Kd", Rgb(1.f)), floats("sigma", {30})}},
      {"oren90", "matte", {color("Kd", {1, .5f, .1f}), floats("sigma", {90})}},
      {"plastic", "plastic", {}},
      {"plasticSharp", "plastic", {floats("roughness", {.01f})}},
      {"plasticGlossy", "plastic", {color("Kd", Rgb(0.f)), color("Ks", Rgb(1.f))}},
      {"plasticVeryRough", "plastic", {color("Kd", Rgb(0.f)), floats("roughness", {100})}},
      {"translucent", "translucent", {}},
      {"translucentGlossy",
       "translucent",
       {color("Kd", Rgb(0.f)), color("Ks", Rgb(1.f)), floats("roughness", {.05f})}},
      {"translucentThrough", "translucent", {color("reflect", Rgb(0.f))}},
      {"copper", "metal", {}},
      {"perfectMetal",
       "metal",
       {color("eta", Rgb(0.f)), color("k", Rgb(0.f)), floats("roughness", {.2f})}},
      {"shinymetal", "shinymetal", {color("Ks", {.5f, .3f, .2f}), color("Kr", Rgb(.3f))}},
      {"substrate", "substrate", {color("Ks", Rgb(.05f))}},
      {"substrateBrushed",
       "substrate",
       {color("Kd", {.1f, .2f, .3f}), floats("uroughness", {.02f}), floats("vroughness", {.5f})}},
      {"uber", "uber", {}},
      {"uberAll",
       "uber",
       {color("Kr", Rgb(.2f)), color("Kt", Rgb(.2f)), color("opacity", {.5f, .7f, 1.f})}},
      {"mix",
       "mix",
       {color("amount", {.3f, .5f, 1.f}), string("namedmaterial1", "rough"),
        string("namedmaterial2", "thin")}},
  };
}

class EveryMaterial : public testing::TestWithParam<Case> {
 protected:
  EveryMaterial() : material_(makeCase(GetParam())) { material_->evaluate(planePoint(), bsdf_); }
  std::unique_ptr<Material> material_;
  Bsdf bsdf_;
  // Steep, oblique, near to grazing, and from behind.
  const std::vector<Vec3> wos_ = {
      fromPlane(localDirection(.98f, .3f)), fromPlane(localDirection(.6f, 2.f)),
      fromPlane(localDirection(.1f, 4.f)), fromPlane(localDirection(-.5f, 1.f))};
};

TEST_P(EveryMaterial, SamplesFollowPdf) {
  for (const Vec3& wo : wos_)
    // Four tests in each of nineteen cases: 1e-4 gives a false alarm in one seed of a hundred.
    EXPECT_GT(chiSquareOfSampling(bsdf_, wo, 40000), 1e-4);
}

TEST_P(EveryMaterial, SampleAgreesWithFAndPdf) {
  Rng rng(1);
  for (const Vec3& wo : wos_)
    for (int i = 0; i < 500; ++i) {
      const float uLobe = rng.uniform();
      const auto s = bsdf_.sample(wo, uLobe, rng.uniform2(), kNonSpecular);
      if (!s) continue;
      EXPECT_NEAR(length(s->wi), 1, 1e-6);
      const BsdfValue v = bsdf_.evaluate(wo, s->wi, kNonSpecular);
      // wi is rounded on its way to render space and back, and an exponent of 100 on a half vector
      // magnifies that by as much; near the horizon the masking term does.
      EXPECT_NEAR(s->pdf, v.pdf, 1e-3f * v.pdf);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(s->f[c], v.f[c], 1e-3f * v.f[c] + 1e-6f);
      EXPECT_EQ(v.f, bsdf_.f(wo, s->wi, kNonSpecular));
      EXPECT_NEAR(v.pdf, bsdf_.pdf(wo, s->wi, kNonSpecular), 1e-6f * v.pdf);
    }
}

TEST_P(EveryMaterial, IsReciprocal) {
  Rng rng(2);
  for (int i = 0; i < 500; ++i) {
    const float c1 = 2 * rng.uniform() - 1, c2 = 2 * rng.uniform() - 1;
    const Vec3 a = fromPlane(localDirection(c1, 6 * rng.uniform()));
    const Vec3 b = fromPlane(localDirection(c2, 6 * rng.uniform()));
    const Rgb ab = bsdf_.f(a, b), ba = bsdf_.f(b, a);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(ab[c], ba[c], 1e-4f * ab[c]);
  }
}

TEST_P(EveryMaterial, AlbedoBySamplingIsItsIntegral) {
  for (const Vec3& wo : wos_) {
    // The midpoint rule is exact to 1e-3 for lobes of exponent 100 with 128 x 256 cells.
    const Rgb exact = integrateF(bsdf_, wo, 128);
    const Estimate sampled = estimateAlbedo(bsdf_, wo, kNonSpecular, 20000);
    const Rgb stratified = bsdf_.reflectance(wo, kNonSpecular, 64);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(sampled.mean[c], exact[c], 5 * sampled.error[c] + 2e-3 * exact[c] + 1e-6);
      // 4096 strata: the error of smooth integrands is far below this.
      EXPECT_NEAR(stratified[c], exact[c], .02f * exact[c] + 1e-6f);
      EXPECT_LE(exact[c], 1.001f);  // all cases are physical
    }
  }
}

TEST_P(EveryMaterial, AllLobesTogetherConserveEnergy) {
  for (const Vec3& wo : wos_) {
    const Estimate e = estimateAlbedo(bsdf_, wo, kAllLobes, 20000);
    for (int c = 0; c < 3; ++c) EXPECT_LE(e.mean[c], 1 + 5 * e.error[c] + 1e-4);
  }
}

TEST_P(EveryMaterial, TellsWhichLobesItHas) {
  EXPECT_LE(bsdf_.lobeCount(), material_->maxLobes());
  EXPECT_EQ(bsdf_.countMatching(kNonSpecular) > 0, material_->hasNonSpecular());
  EXPECT_EQ(bsdf_.countMatching(kNonSpecular) < bsdf_.lobeCount(), material_->hasSpecular());
}

TEST_P(EveryMaterial, ConstantReflectionIsWhatFSays) {
  const auto constant = bsdf_.constantReflection(kNonSpecular);
  const std::string name = GetParam().label;
  if (name.starts_with("matte")) {
    EXPECT_TRUE(constant);
  }
  if (name.starts_with("oren") || name.starts_with("translucent")) {
    EXPECT_FALSE(constant);
  }
  if (!constant) return;
  Rng rng(9);
  for (const Vec3& wo : wos_)
    for (int i = 0; i < 50; ++i) {
      const Vec3 wi = sampleUniformSphere(rng.uniform2());
      const Vec3& ng = bsdf_.geometricNormal();
      const bool reflects = (dot(wi, ng) > 0) == (dot(wo, ng) > 0);
      EXPECT_EQ(bsdf_.f(wo, wi, kNonSpecular), reflects ? *constant : Rgb());
    }
}

TEST_P(EveryMaterial, IsFiniteAtGrazingAngles) {
  std::vector<Vec3> directions;
  for (const float cosine : {0.f, 1e-38f, 1e-20f, 1e-7f, 1e-3f, 1.f, -1e-38f, -1e-7f, -1.f})
    for (const float phi : {0.f, 1.f, kPi}) directions.push_back(localDirection(cosine, phi));
  // The plane's own frame, so that exact zeros stay zeros.
  SurfaceInteraction at;
  at.shading.dpdu = {1, 0, 0};
  at.shading.dpdv = {0, 1, 0};
  Bsdf bsdf;
  material_->evaluate(at, bsdf);
  Rng rng(3);
  for (const Vec3& wo : directions) {
    for (const Vec3& wi : directions) {
      const BsdfValue v = bsdf.evaluate(wo, wi);
      EXPECT_TRUE(v.f.isFinite() && v.f.minChannel() >= 0);
      EXPECT_TRUE(std::isfinite(v.pdf) && v.pdf >= 0);
    }
    for (int i = 0; i < 20; ++i) {
      const float uLobe = rng.uniform();
      const auto s =
          bsdf.sample(wo, uLobe, i < 2 ? Vec2(i == 0 ? 0.f : kOneMinusEpsilon) : rng.uniform2());
      if (!s) continue;
      EXPECT_TRUE(isFinite(s->wi) && s->pdf > 0 && std::isfinite(s->pdf));
      const Rgb weight = s->f * (absDot(s->wi, bsdf.shadingNormal()) / s->pdf);
      EXPECT_TRUE(weight.isFinite() && weight.minChannel() >= 0);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Materials, EveryMaterial, testing::ValuesIn(allCases()),
                         [](const auto& test) { return std::string(test.param.label); });

// --- parameters ----------------------------------------------------------------------------------

struct RangeCase {
  const char* material;
  const char* param;
  bool isColor;
  float lo, hi, below, above;  ///< ends of the range and values outside; NaN: there are none
};
void PrintTo(const RangeCase& c, std::ostream* out) { *out << c.material << ' ' << c.param; }
constexpr float kMax = std::numeric_limits<float>::max();
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr float kDenormal = std::numeric_limits<float>::denorm_min();

const std::vector<RangeCase> kRangeCases = {
    {"matte", "Kd", true, 0, kMax, -.1f, kNone},
    {"matte", "sigma", false, 0, 90, -1, 91},
    {"matte", "bumpmap", false, -kMax, kMax, kNone, kNone},
    {"mirror", "Kr", true, 0, kMax, -.1f, kNone},
    {"glass", "Kr", true, 0, kMax, -.1f, kNone},
    {"glass", "Kt", true, 0, kMax, -.1f, kNone},
    {"glass", "index", false, kDenormal, 1e6f, 0, 2e6f},
    {"plastic", "Kd", true, 0, kMax, -.1f, kNone},
    {"plastic", "Ks", true, 0, kMax, -.1f, kNone},
    {"plastic", "roughness", false, 0, kMax, -.1f, kNone},
    {"translucent", "Kd", true, 0, kMax, -.1f, kNone},
    {"translucent", "Ks", true, 0, kMax, -.1f, kNone},
    {"translucent", "reflect", true, 0, kMax, -.1f, kNone},
    {"translucent", "transmit", true, 0, kMax, -.1f, kNone},
    {"translucent", "roughness", false, 0, kMax, -.1f, kNone},
    {"metal", "eta", true, 0, 1e6f, -.1f, 2e6f},
    {"metal", "k", true, 0, 1e6f, -.1f, 2e6f},
    {"metal", "roughness", false, 0, kMax, -.1f, kNone},
    {"shinymetal", "Kr", true, 0, kMax, -.1f, kNone},
    {"shinymetal", "Ks", true, 0, kMax, -.1f, kNone},
    {"shinymetal", "roughness", false, 0, kMax, -.1f, kNone},
    {"substrate", "Kd", true, 0, kMax, -.1f, kNone},
    {"substrate", "Ks", true, 0, kMax, -.1f, kNone},
    {"substrate", "uroughness", false, 0, kMax, -.1f, kNone},
    {"substrate", "vroughness", false, 0, kMax, -.1f, kNone},
    {"uber", "Kd", true, 0, kMax, -.1f, kNone},
    {"uber", "Ks", true, 0, kMax, -.1f, kNone},
    {"uber", "Kr", true, 0, kMax, -.1f, kNone},
    {"uber", "Kt", true, 0, kMax, -.1f, kNone},
    {"uber", "opacity", true, 0, kMax, -.1f, kNone},
    {"uber", "roughness", false, 0, kMax, -.1f, kNone},
    {"uber", "index", false, kDenormal, 1e6f, 0, 2e6f},
    {"mix", "amount", true, 0, kMax, -.1f, kNone},
};

class ParameterRange : public testing::TestWithParam<RangeCase> {};

TEST_P(ParameterRange, EndsAreAcceptedAndValuesOutsideAreNot) {
  const RangeCase& c = GetParam();
  const auto param = [&](float v) {
    return c.isColor ? color(c.param, Rgb(v)) : floats(c.param, {v});
  };
  Material::FactoryContext context;
  context.named = &mixable();
  const auto made = [&](float v) {
    std::vector<Param> params{param(v)};
    if (std::string_view(c.material) == "mix") {
      params.push_back(string("namedmaterial1", "rough"));
      params.push_back(string("namedmaterial2", "thin"));
    }
    return make<Material>(c.material, std::move(params), context);
  };
  for (const float v : {c.lo, c.hi}) {
    const std::unique_ptr<Material> material = made(v);
    ASSERT_TRUE(material);
    Bsdf bsdf;
    material->evaluate(planePoint(), bsdf);
    EXPECT_LE(bsdf.lobeCount(), material->maxLobes());
    Rng rng(4);
    for (int i = 0; i < 50; ++i) {
      const Vec3 wo = fromPlane(localDirection(2 * rng.uniform() - 1, 6 * rng.uniform()));
      const float uLobe = rng.uniform();
      const auto s = bsdf.sample(wo, uLobe, rng.uniform2());
      if (!s) continue;
      EXPECT_TRUE(isFinite(s->wi));
      for (int channel = 0; channel < 3; ++channel) EXPECT_GE(s->f[channel], 0);  // no NaN either
    }
  }
  // Colours below 0, which spectra can become, count as 0 with a warning.
  if (c.isColor && c.below < 0) {
    EXPECT_NO_THROW(made(c.below));
  }
  for (const float v : {c.isColor ? std::nanf("") : c.below, c.above})
    if (!std::isnan(v)) {
      EXPECT_THROW(made(v), SceneError) << v;
    }
}

INSTANTIATE_TEST_SUITE_P(Materials, ParameterRange, testing::ValuesIn(kRangeCases),
                         [](const auto& test) {
                           return std::string(test.param.material) + "_" + test.param.param;
                         });

TEST(Materials, EveryNumberHasARangeTest) {
  for (const auto* entry : Registry<Material>::entries())
    for (const ParamRecord& record : entry->describe()) {
      if (record.name == "bumpmap" || record.range.empty()) continue;
      EXPECT_TRUE(std::any_of(
          kRangeCases.begin(), kRangeCases.end(),
          [&](const RangeCase& c) { return c.material == entry->name && c.param == record.name; }))
          << entry->name << " " << record.name;
    }
}

}  // namespace
}  // namespace brume::test
