// SPDX-License-Identifier: Apache-2.0
// Closed forms of each material.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/rng.h"
#include "core/sampling.h"
#include "support/bsdf_checks.h"

namespace brume::test {
namespace {

using testing::HasSubstr;

/// A material at planePoint().
struct Shaded {
  explicit Shaded(std::string_view name, std::vector<Param> params = {},
                  Material::FactoryContext::Lookup* named = nullptr) {
    Material::FactoryContext context;
    context.named = named;
    material = make<Material>(name, std::move(params), context);
    material->evaluate(planePoint(), bsdf);
  }
  std::unique_ptr<Material> material;
  Bsdf bsdf;
};

/// The specular sample of the given kind for the local direction wo, as local direction and weight.
struct Specular {
  Vec3 wi{0};
  Rgb weight;
  float eta = 1;
};
std::optional<Specular> specular(const Bsdf& bsdf, const Vec3& wo, LobeFlags kind) {
  const auto s = bsdf.sample(fromPlane(wo), .5f, {.3f, .7f}, kind | kSpecular);
  if (!s) return std::nullopt;
  EXPECT_TRUE(s->isSpecular());
  EXPECT_EQ(s->isTransmission(), kind == kTransmission);
  return Specular{bsdf.frame().toLocal(s->wi),
                  s->f * (absDot(s->wi, bsdf.shadingNormal()) / s->pdf), s->eta};
}

/// Fresnel's reflectance in double, textbook form.
double fresnel(double cosI, double etaI, double etaT) {
  const double sinT = etaI / etaT * std::sqrt(1 - cosI * cosI);
  if (sinT >= 1) return 1;
  const double cosT = std::sqrt(1 - sinT * sinT);
  const double rs = (etaI * cosI - etaT * cosT) / (etaI * cosI + etaT * cosT);
  const double rp = (etaI * cosT - etaT * cosI) / (etaI * cosT + etaT * cosI);
  return (rs * rs + rp * rp) / 2;
}

TEST(Matte, LambertReflectsKd) {
  const Rgb kd{.2f, .5f, 1};
  const Shaded m("matte", {color("Kd", kd)});
  const Vec3 wo = fromPlane(localDirection(.4f, 1));
  const Rgb f = m.bsdf.f(wo, fromPlane(localDirection(.9f, 3)));
  const Rgb albedo = m.bsdf.reflectance(wo, kAllLobes);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(f[c], kd[c] / kPi, 1e-6);
    EXPECT_NEAR(albedo[c], kd[c], 1e-5);  // every sample has the same weight, to rounding
  }
  // The two sides are alike, and nothing passes.
  EXPECT_EQ(m.bsdf.f(-wo, fromPlane(localDirection(-.9f, 3))), f);
  EXPECT_TRUE(m.bsdf.f(wo, fromPlane(localDirection(-.9f, 3))).isBlack());
}

TEST(Matte, OrenNayarIsTheTrigonometricFormula) {
  const double sigma = 25 * 3.14159265358979 / 180, s2 = sigma * sigma;
  const double a = 1 - s2 / (2 * (s2 + .33)), b = .45 * s2 / (s2 + .09);
  const Shaded m("matte", {color("Kd", Rgb(.8f)), floats("sigma", {25})});
  for (const float thetaO : {.1f, .7f, 1.4f})
    for (const float thetaI : {.2f, .9f, 1.5f})
      for (const float dphi : {0.f, 1.f, 2.f, 3.f}) {
        const double alpha = std::max(thetaO, thetaI), beta = std::min(thetaO, thetaI);
        const double expected =
            .8 / 3.14159265358979 *
            (a + b * std::max(0.0, std::cos(double{dphi})) * std::sin(alpha) * std::tan(beta));
        const Rgb f = m.bsdf.f(fromPlane(localDirection(std::cos(thetaO), .5f)),
                               fromPlane(localDirection(std::cos(thetaI), .5f + dphi)));
        EXPECT_NEAR(f.r, expected, 1e-5 * expected);
      }
}

TEST(Matte, OrenNayarBecomesLambert) {
  const Shaded lambert("matte"), smooth("matte", {floats("sigma", {.01f})});
  const Vec3 wo = fromPlane(localDirection(.3f, 1)), wi = fromPlane(localDirection(.4f, 1.2f));
  EXPECT_NEAR(smooth.bsdf.f(wo, wi).r, lambert.bsdf.f(wo, wi).r, 1e-6);
}

TEST(Matte, BlackHasNoLobe) {
  const Shaded m("matte", {color("Kd", Rgb(0.f))});
  EXPECT_EQ(m.bsdf.lobeCount(), 0);
  EXPECT_FALSE(m.material->hasNonSpecular());
  EXPECT_FALSE(m.bsdf.sample(m.bsdf.shadingNormal(), 0, {.5f, .5f}));
}

TEST(Mirror, ReflectsKrAboutTheNormal) {
  const Shaded m("mirror", {color("Kr", {.9f, .5f, .1f})});
  for (const float cosine : {1.f, .5f, 1e-3f, -.7f}) {
    const Vec3 wo = localDirection(cosine, 1);
    const auto s = specular(m.bsdf, wo, kReflection);
    ASSERT_TRUE(s);
    EXPECT_NEAR(distance(s->wi, {-wo.x, -wo.y, wo.z}), 0, 1e-6);
    EXPECT_NEAR(s->weight.r, .9f, 1e-6);
    EXPECT_NEAR(s->weight.b, .1f, 1e-6);
  }
  EXPECT_TRUE(m.material->hasSpecular());
  EXPECT_TRUE(m.bsdf.isSpecularOnly());
}

TEST(Glass, NoPathThroughItGainsPower) {
  // f cos / pdf of glass is 1 for every lobe and direction: by half and half it would be up to 2,
  // and grow with every total reflection inside.
  const Shaded glass("glass", {floats("index", {1.5f})});
  Rng rng(3);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 wo = sampleUniformSphere(rng.uniform2());
    const auto s = glass.bsdf.sample(wo, rng.uniform(), rng.uniform2());
    ASSERT_TRUE(s);
    EXPECT_NEAR(s->f.g * absDot(s->wi, glass.bsdf.shadingNormal()) / s->pdf, 1, 1e-4f);
  }
}

TEST(Glass, ObeysFresnelAndSnell) {
  const Shaded m("glass", {floats("index", {1.5f})});
  const auto normal = specular(m.bsdf, {0, 0, 1}, kReflection);
  ASSERT_TRUE(normal);
  EXPECT_NEAR(normal->weight.g, .04f, 1e-6);  // ((1.5 - 1) / (1.5 + 1))^2
  for (const float cosine : {.99f, .6f, .2f, .01f, -.99f, -.8f}) {
    const Vec3 wo = localDirection(cosine, 2);
    const double etaI = cosine > 0 ? 1 : 1.5, etaT = cosine > 0 ? 1.5 : 1;
    const double f = fresnel(std::abs(cosine), etaI, etaT);
    const auto reflected = specular(m.bsdf, wo, kReflection);
    const auto refracted = specular(m.bsdf, wo, kTransmission);
    ASSERT_TRUE(reflected && refracted);
    EXPECT_NEAR(reflected->weight.r, f, 1e-5);
    EXPECT_NEAR(refracted->weight.r, 1 - f, 1e-5);  // no factor eta^2
    EXPECT_NEAR(reflected->weight.r + refracted->weight.r, 1, 1e-5);
    // Snell: the tangential parts have the ratio of the indices; the sides differ.
    EXPECT_NEAR(refracted->wi.x * etaT, -wo.x * etaI, 1e-5);
    EXPECT_NEAR(refracted->wi.y * etaT, -wo.y * etaI, 1e-5);
    EXPECT_LT(refracted->wi.z * wo.z, 0);
    EXPECT_NEAR(refracted->eta, etaI / etaT, 1e-6);
  }
}

TEST(Glass, ReflectsTotallyBeyondTheCriticalAngle) {
  const Shaded m("glass", {floats("index", {1.5f})});
  const float critical = std::sqrt(1 - 1 / (1.5f * 1.5f));
  EXPECT_TRUE(specular(m.bsdf, localDirection(-critical - .001f, 0), kTransmission));
  EXPECT_FALSE(specular(m.bsdf, localDirection(-critical + .001f, 0), kTransmission));
  EXPECT_NEAR(specular(m.bsdf, localDirection(-critical + .001f, 0), kReflection)->weight.r, 1,
              1e-6);
}

TEST(Glass, OfIndexOneIsNotThere) {
  const Shaded m("glass", {floats("index", {1})});
  for (const float cosine : {1.f, .3f, 1e-4f, -.5f}) {
    const Vec3 wo = localDirection(cosine, 1);
    const auto s = specular(m.bsdf, wo, kTransmission);
    ASSERT_TRUE(s);
    EXPECT_NEAR(distance(s->wi, -wo), 0, 1e-6);
    EXPECT_NEAR(s->weight.r, 1, 1e-5);
    EXPECT_FALSE(specular(m.bsdf, wo, kReflection));
  }
}

TEST(Bsdf, ChoosesSpecularLobesByWhatTheyScatter) {
  const Shaded m("glass", {floats("index", {1.5f})});
  const Vec3 wo = fromPlane(localDirection(.5f, 0));
  const auto f = static_cast<float>(fresnel(.5, 1, 1.5));
  const auto first = m.bsdf.sample(wo, f - .01f, {0, 0}),
             second = m.bsdf.sample(wo, f + .01f, {0, 0});
  ASSERT_TRUE(first && second);
  EXPECT_NEAR(first->pdf, f, 1e-5f);
  EXPECT_NEAR(second->pdf, 1 - f, 1e-5f);
  EXPECT_FALSE(first->isTransmission());
  EXPECT_TRUE(second->isTransmission());
}

TEST(Plastic, HasBlinnsFacetsAndReversedFresnel) {
  const Shaded m("plastic",
                 {color("Kd", Rgb(0.f)), color("Ks", Rgb(.3f)), floats("roughness", {.1f})});
  for (const float thetaO : {0.f, .4f, 1.f})
    for (const float thetaI : {0.f, .6f, 1.2f})
      for (const float phi : {0.f, 2.f, 3.f}) {
        const Vec3 wo = localDirection(std::cos(thetaO), 0);
        const Vec3 wi = localDirection(std::cos(thetaI), phi);
        const Vec3d h = normalize(Vec3d(wo) + Vec3d(wi));
        const double oh = dot(Vec3d(wo), h);
        const double d = 12 / (2 * 3.14159265358979) * std::pow(h.z, 10);
        const double g = std::min(1.0, std::min(2 * h.z * wo.z / oh, 2 * h.z * wi.z / oh));
        const double expected = .3 * d * g * fresnel(oh, 1.5, 1) / (4.0 * wo.z * wi.z);
        EXPECT_NEAR(m.bsdf.f(fromPlane(wo), fromPlane(wi)).r, expected, 1e-4 * expected);
      }
}

TEST(Plastic, ExponentIsCappedAtTenThousand) {
  const Shaded zero("plastic", {color("Kd", Rgb(0.f)), floats("roughness", {0})});
  const Shaded cap("plastic", {color("Kd", Rgb(0.f)), floats("roughness", {1e-4f})});
  const Vec3 n = zero.bsdf.shadingNormal();
  EXPECT_EQ(zero.bsdf.f(n, n), cap.bsdf.f(n, n));
  EXPECT_NEAR(zero.bsdf.f(n, n).r, .25 * .04 * 10002 / (2 * 3.14159265) / 4, 1e-3);
}

TEST(Translucent, MirrorsPlasticToTheOtherSide) {
  const std::vector<Param> coat{color("Kd", Rgb(.6f)), color("Ks", Rgb(.2f))};
  std::vector<Param> params = coat;
  params.push_back(color("reflect", {.1f, .2f, .3f}));
  params.push_back(color("transmit", {.4f, .5f, .6f}));
  const Shaded plastic("plastic", coat), m("translucent", params);
  const Vec3 wo = localDirection(.7f, 1), wi = localDirection(.4f, 3);
  const Rgb base = plastic.bsdf.f(fromPlane(wo), fromPlane(wi));
  const Rgb reflected = m.bsdf.f(fromPlane(wo), fromPlane(wi));
  const Rgb transmitted = m.bsdf.f(fromPlane(wo), fromPlane({wi.x, wi.y, -wi.z}));
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(reflected[c], base[c] * (.1f + .1f * static_cast<float>(c)), 1e-5);
    EXPECT_NEAR(transmitted[c], base[c] * (.4f + .1f * static_cast<float>(c)), 1e-5);
  }
}

TEST(Metal, ReflectsAsAConductorAtNormalIncidence) {
  const Shaded m("metal",
                 {color("eta", Rgb(.2f)), color("k", Rgb(3.9f)), floats("roughness", {1})});
  const Vec3 n = m.bsdf.shadingNormal();
  const double f0 = (sqr(.2 - 1) + sqr(3.9)) / (sqr(.2 + 1) + sqr(3.9));
  EXPECT_NEAR(m.bsdf.f(n, n).r, f0 * 3 / (2 * 3.14159265) / 4, 1e-5);
}

TEST(Metal, IsCopperByDefault) {
  // Copper's index and absorption for Rec. 709, as other renderers that use the same measurement
  // list them (0.2004, 0.9240, 1.1022; 3.9129, 2.4528, 2.1422), to their rounding.
  const auto* entry = Registry<Material>::find("metal");
  ASSERT_TRUE(entry);
  const Shaded copper("metal", {floats("roughness", {1})});
  const Shaded same("metal", {color("eta", {.2004f, .9240f, 1.1022f}),
                              color("k", {3.9129f, 2.4528f, 2.1422f}), floats("roughness", {1})});
  const Vec3 n = copper.bsdf.shadingNormal();
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(copper.bsdf.f(n, n)[c], same.bsdf.f(n, n)[c], .005f * same.bsdf.f(n, n)[c]);
}

TEST(Metal, PerfectConductorWithSharpFacetsReflectsAll) {
  const Shaded m("metal", {color("eta", Rgb(0.f)), color("k", Rgb(0.f)), floats("roughness", {0})});
  // Facets of exponent 10000 hide each other by less than 1 %.
  EXPECT_NEAR(m.bsdf.reflectance(m.bsdf.shadingNormal(), kAllLobes, 32).r, 1, .01);
}

TEST(ShinyMetal, ReflectsKrAndKsAtNormalIncidence) {
  const Shaded m("shinymetal", {color("Kr", {.1f, .5f, .9f}), color("Ks", {.2f, .6f, .8f}),
                                floats("roughness", {1})});
  const auto s = specular(m.bsdf, {0, 0, 1}, kReflection);
  ASSERT_TRUE(s);
  const Vec3 n = m.bsdf.shadingNormal();
  const Rgb f = m.bsdf.f(n, n);
  const float blinn = 3 / (2 * kPi) / 4;
  const Rgb kr{.1f, .5f, .9f}, ks{.2f, .6f, .8f};
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(s->weight[c], kr[c], 1e-5);
    EXPECT_NEAR(f[c], ks[c] * blinn, 1e-5);
  }
}

TEST(Substrate, IsAshikhminShirley) {
  const double rd = .4, rs = .1, ex = 50, ey = 4;
  const Shaded m("substrate", {color("Kd", Rgb(.4f)), color("Ks", Rgb(.1f)),
                               floats("uroughness", {1 / 50.f}), floats("vroughness", {.25f})});
  for (const float thetaO : {0.f, .5f, 1.2f})
    for (const float thetaI : {0.f, .3f, 1.f})
      for (const float phi : {0.f, 1.5f, 3.1f}) {
        const Vec3 wo = localDirection(std::cos(thetaO), .7f);
        const Vec3 wi = localDirection(std::cos(thetaI), phi);
        const Vec3d h = normalize(Vec3d(wo) + Vec3d(wi));
        const double sin2 = h.x * h.x + h.y * h.y, c = dot(Vec3d(wi), h);
        const double e = sin2 > 1e-12 ? (ex * h.x * h.x + ey * h.y * h.y) / sin2 : 0;
        const double d = std::sqrt((ex + 2) * (ey + 2)) / (2 * 3.14159265358979) * std::pow(h.z, e);
        const double coat =
            d * (rs + std::pow(1 - c, 5) * (1 - rs)) / (4 * c * std::max(wo.z, wi.z));
        const double base = 28 / (23 * 3.14159265358979) * rd * (1 - rs) *
                            (1 - std::pow(1 - wi.z / 2.0, 5)) * (1 - std::pow(1 - wo.z / 2.0, 5));
        EXPECT_NEAR(m.bsdf.f(fromPlane(wo), fromPlane(wi)).r, base + coat, 1e-4 * (base + coat));
      }
}

TEST(Uber, RefractsWithTheDenseSideOutside) {
  const Shaded m("uber", {color("Kd", Rgb(0.f)), color("Ks", Rgb(0.f)), color("Kr", Rgb(1.f)),
                          color("Kt", Rgb(1.f)), floats("index", {1.5f})});
  const Vec3 wo = localDirection(.9f, 1);
  const auto refracted = specular(m.bsdf, wo, kTransmission);
  ASSERT_TRUE(refracted);
  EXPECT_NEAR(refracted->wi.x, -1.5f * wo.x, 1e-5);
  EXPECT_NEAR(refracted->weight.r, 1 - fresnel(.9, 1.5, 1), 1e-5);
  // 60 degrees from outside is beyond the critical angle.
  EXPECT_FALSE(specular(m.bsdf, localDirection(.5f, 1), kTransmission));
  EXPECT_NEAR(specular(m.bsdf, localDirection(.5f, 1), kReflection)->weight.r, 1, 1e-6);
  EXPECT_TRUE(specular(m.bsdf, localDirection(-.5f, 1), kTransmission));
}

TEST(Uber, OpacityScalesAllAndTheRestPassesStraightThrough) {
  const Rgb opacity{.2f, .5f, 1};
  const Shaded opaque("uber"), m("uber", {color("opacity", opacity)});
  const Vec3 wo = localDirection(.3f, 1), wi = localDirection(.8f, 2);
  const auto s = specular(m.bsdf, wo, kTransmission);
  ASSERT_TRUE(s);
  EXPECT_NEAR(distance(s->wi, -wo), 0, 1e-6);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(s->weight[c], 1 - opacity[c], 1e-6);
    EXPECT_NEAR(m.bsdf.f(fromPlane(wo), fromPlane(wi))[c],
                opacity[c] * opaque.bsdf.f(fromPlane(wo), fromPlane(wi))[c], 1e-6);
  }
  EXPECT_TRUE(m.material->hasSpecular());
  EXPECT_FALSE(opaque.material->hasSpecular());
}

// --- mix -----------------------------------------------------------------------------------------

class MixTest : public testing::Test {
 protected:
  MixTest() {
    named_.add("a", make<Material>("plastic", {color("Kd", {.1f, .2f, .3f})}));
    named_.add("b", make<Material>("mirror", {color("Kr", Rgb(.8f))}));
    named_.add("c", make<Material>("translucent", {}));
    for (const char* name : {"full1", "full2"})
      named_.add(name, make<Material>("uber", {color("Kr", Rgb(.1f)), color("Kt", Rgb(.1f)),
                                               color("opacity", Rgb(.5f))}));
  }
  static std::vector<Param> params(const Rgb& amount, const char* first, const char* second) {
    return {color("amount", amount), string("namedmaterial1", first),
            string("namedmaterial2", second)};
  }
  std::string errorOf(std::vector<Param> p) {
    try {
      Shaded m("mix", std::move(p), &named_);
    } catch (const SceneError& e) {
      return e.what();
    }
    return "";
  }
  NamedMaterials named_;
  const Vec3 wo_ = fromPlane(localDirection(.6f, 1)), wi_ = fromPlane(localDirection(.4f, 2));
};

TEST_F(MixTest, IsTheWeightedSum) {
  const Rgb amount{.25f, .5f, .75f};
  const Shaded m("mix", params(amount, "a", "c"), &named_);
  Bsdf a, c;
  named_.findMaterial("a")->evaluate(planePoint(), a);
  named_.findMaterial("c")->evaluate(planePoint(), c);
  const Rgb f = m.bsdf.f(wo_, wi_);
  const Rgb expected = amount * a.f(wo_, wi_) + (Rgb(1.f) - amount) * c.f(wo_, wi_);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(f[i], expected[i], 1e-6);
  EXPECT_EQ(m.bsdf.scale(), Rgb(1.f));
}

TEST_F(MixTest, ScalesSpecularLobes) {
  const Shaded m("mix", params({.25f, .5f, .75f}, "a", "b"), &named_);
  const auto s = specular(m.bsdf, localDirection(.5f, 0), kReflection);
  ASSERT_TRUE(s);
  EXPECT_NEAR(s->weight.r, .8f * .75f, 1e-6);
  EXPECT_NEAR(s->weight.b, .8f * .25f, 1e-6);
  EXPECT_TRUE(m.material->hasSpecular() && m.material->hasNonSpecular());
}

TEST_F(MixTest, AmountOneIsTheFirst) {
  const Shaded first("mix", params(Rgb(1.f), "a", "b"), &named_);
  EXPECT_FALSE(first.material->hasSpecular());
  Bsdf a;
  named_.findMaterial("a")->evaluate(planePoint(), a);
  EXPECT_EQ(first.bsdf.f(wo_, wi_), a.f(wo_, wi_));
  const Shaded second("mix", params(Rgb(0.f), "a", "b"), &named_);
  EXPECT_TRUE(second.bsdf.isSpecularOnly());
}

TEST_F(MixTest, Nests) {
  Material::FactoryContext context;
  context.named = &named_;
  named_.add("ab", make<Material>("mix", params(Rgb(.5f), "a", "b"), context));
  const Shaded m("mix", params(Rgb(.5f), "ab", "b"), &named_);
  Bsdf a;
  named_.findMaterial("a")->evaluate(planePoint(), a);
  EXPECT_NEAR(m.bsdf.f(wo_, wi_).g, .25f * a.f(wo_, wi_).g, 1e-7);
}

TEST_F(MixTest, NamesWhatIsWrong) {
  EXPECT_THAT(errorOf(params(Rgb(.5f), "a", "ful1")),
              testing::AllOf(HasSubstr("no material is named 'ful1'"), HasSubstr("'full1'")));
  EXPECT_THAT(errorOf({string("namedmaterial1", "a")}), HasSubstr("namedmaterial2"));
  EXPECT_THAT(errorOf(params(Rgb(.5f), "full1", "full2")),
              HasSubstr("needs 10 lobes; at most 8 are possible"));
}

}  // namespace
}  // namespace brume::test
