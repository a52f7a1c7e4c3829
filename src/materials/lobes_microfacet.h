// SPDX-License-Identifier: Apache-2.0
// Glossy lobes of microfacets. D is the density of facet normals wh: Int D(wh) cos(wh) dwh = 1.
// Directions are sampled by way of wh with density ~ cos^e, and rejected (no sample) when they
// leave through the other side; pdf is 0 there, so nothing is biased.
#pragma once

#include "materials/lobes.h"

namespace brume {

/// 1 / roughness, at most 10000; roughness 0 gives the cap (as PBRT-v2).
inline float exponentFromRoughness(float roughness) {
  constexpr float kMaxExponent = 10000.f;
  return roughness > 1.f / kMaxExponent ? 1.f / roughness : kMaxExponent;
}

/// log(1 - x) for 0 <= x < 1 to a few ulps; thrice as fast as log1p. Source: Goldberg 1991, theorem
/// 4: the rounding of 1 - x cancels between log(u) and 1 - u.
inline float logOneMinus(float x) {
  const float u = 1.f - x;
  return u == 1.f ? -x : std::log(u) * (x / (1.f - u));
}

/// Isotropic facets: D = (e + 2) / (2 pi) cos^e. Source: Blinn 1977.
class BlinnDistribution {
 public:
  explicit BlinnDistribution(float exponent) : e_(exponent) {}
  /// cos^e, common to D and pdf. From the sine, which is exact where the cosine is nearly 1.
  float power(const Vec3& wh) const {
    const float sin2 = wh.x * wh.x + wh.y * wh.y;
    return sin2 < 1.f ? std::exp(.5f * e_ * logOneMinus(sin2)) : 0.f;
  }
  float dFactor() const { return (e_ + 2.f) * (.5f * kInvPi); }
  /// Density of sample() per solid angle of wh is pdfFactor * power.
  float pdfFactor() const { return (e_ + 1.f) * (.5f * kInvPi); }
  /// A facet normal with z >= 0.
  Vec3 sample(Vec2 u) const;

 private:
  float e_;
};

/// Facets with exponents ex along x and ey along y: D = sqrt((ex+2)(ey+2)) / (2 pi) cos^(ex cos^2
/// phi + ey sin^2 phi). Source: Ashikhmin, Shirley 2000.
class AnisotropicDistribution {
 public:
  AnisotropicDistribution(float ex, float ey) : ex_(ex), ey_(ey) {}
  float power(const Vec3& wh) const {
    const float x2 = wh.x * wh.x, y2 = wh.y * wh.y, sin2 = x2 + y2;
    if (sin2 >= 1.f) return 0.f;
    const float logCosOverSin2 = sin2 > 1e-30f ? .5f * logOneMinus(sin2) / sin2 : -.5f;
    return std::exp((ex_ * x2 + ey_ * y2) * logCosOverSin2);
  }
  float dFactor() const { return std::sqrt((ex_ + 2.f) * (ey_ + 2.f)) * (.5f * kInvPi); }
  float pdfFactor() const { return std::sqrt((ex_ + 1.f) * (ey_ + 1.f)) * (.5f * kInvPi); }
  Vec3 sample(Vec2 u) const;

 private:
  float ex_, ey_;
};

/// The facet normal between two directions, and its cosine with both; none when they are opposite.
struct HalfVector {
  Vec3 wh;
  float cosine;
};
inline std::optional<HalfVector> halfVector(const Vec3& wo, const Vec3& wi) {
  const Vec3 sum = wo + wi;
  const float l2 = lengthSquared(sum);
  if (!(l2 >= std::numeric_limits<float>::min())) return std::nullopt;
  const float l = std::sqrt(l2);
  return HalfVector{sum / l, .5f * l};  // |wo + wi| = 2 cos for unit vectors
}

/// wi with the facet normal wh (turned to the side of wo) halfway to wo; none when it would leave
/// through the other side.
std::optional<Vec3> reflectAbout(const Vec3& wo, Vec3 wh);

/// Torrance-Sparrow: f = R D(wh) G F(wi.wh) / (4 cos_o cos_i), V-shaped grooves G = min(1, 2 cos_h
/// cos_o / wo.wh, 2 cos_h cos_i / wo.wh). Source: Torrance, Sparrow 1967.
template <class Fresnel>
class MicrofacetLobe final : public Lobe {
 public:
  MicrofacetLobe(const Rgb& reflectance, const BlinnDistribution& distribution,
                 const Fresnel& fresnel)
      : Lobe(kReflection | kGlossy),
        reflectance_(reflectance),
        distribution_(distribution),
        fresnel_(fresnel) {}

  Rgb f(const Vec3& wo, const Vec3& wi) const override { return evaluate(wo, wi).f; }

  float pdf(const Vec3& wo, const Vec3& wi) const override {
    if (!sameHemisphere(wo, wi)) return 0.f;
    const auto h = halfVector(wo, wi);
    return h ? distribution_.pdfFactor() * distribution_.power(h->wh) / (4.f * h->cosine) : 0.f;
  }

  BsdfValue evaluate(const Vec3& wo, const Vec3& wi) const override {
    const auto h = halfVector(wo, wi);
    if (!h) return {};
    const float power = distribution_.power(h->wh);
    const float pdf =
        sameHemisphere(wo, wi) ? distribution_.pdfFactor() * power / (4.f * h->cosine) : 0.f;
    if (power == 0.f) return {Rgb(), pdf};
    return {reflectance_ * fresnel_(h->cosine) *
                (distribution_.dFactor() * power * geometry(wo, wi, *h)),
            pdf};
  }

  std::optional<BsdfSample> sample(const Vec3& wo, Vec2 u) const override {
    const std::optional<Vec3> wi = reflectAbout(wo, distribution_.sample(u));
    if (!wi) return std::nullopt;
    const BsdfValue value = evaluate(wo, *wi);
    if (!(value.pdf > 0.f)) return std::nullopt;
    return BsdfSample{value.f, *wi, value.pdf, flags()};
  }

 private:
  /// G / (4 cos_o cos_i), in a form that is finite unless both cosines are 0.
  static float geometry(const Vec3& wo, const Vec3& wi, const HalfVector& h) {
    const float o = absCosTheta(wo), i = absCosTheta(wi), larger = std::max(o, i);
    if (!(larger > 0.f)) return 0.f;
    const float masked = absCosTheta(h.wh) / (2.f * h.cosine * larger);
    return std::min(.25f / (o * i), masked);
  }

  Rgb reflectance_;
  BlinnDistribution distribution_;
  Fresnel fresnel_;
};

/// A diffuse base under a glossy coat (Ashikhmin, Shirley 2000), c = wi.wh:
///   f = 28/(23 pi) Rd (1 - Rs) (1 - (1 - cos_i/2)^5) (1 - (1 - cos_o/2)^5)
///     + D(wh) (Rs + (1 - c)^5 (1 - Rs)) / (4 c max(cos_i, cos_o))
/// Half of the samples follow the cosine, half D.
class FresnelBlendLobe final : public Lobe {
 public:
  FresnelBlendLobe(const Rgb& rd, const Rgb& rs, const AnisotropicDistribution& distribution);
  Rgb f(const Vec3& wo, const Vec3& wi) const override { return evaluate(wo, wi).f; }
  float pdf(const Vec3& wo, const Vec3& wi) const override { return evaluate(wo, wi).pdf; }
  BsdfValue evaluate(const Vec3& wo, const Vec3& wi) const override;
  std::optional<BsdfSample> sample(const Vec3& wo, Vec2 u) const override;

 private:
  Rgb diffuse_, rs_;
  AnisotropicDistribution distribution_;
};

}  // namespace brume
