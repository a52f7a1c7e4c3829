// SPDX-License-Identifier: Apache-2.0
#include "materials/lobes_microfacet.h"

#include "core/sampling.h"

namespace brume {

namespace {

/// The direction with azimuth along the unit vector (x, y) and cos = (1 - u)^(1/(e+1)), the sine
/// without cancellation near the pole.
Vec3 fromPower(float x, float y, float u, float exponent) {
  const float logCos = logOneMinus(u) / (exponent + 1.f);
  const float sin2 = -std::expm1(2.f * logCos);
  const float sine = std::sqrt(sin2);
  return {sine * x, sine * y, std::sqrt(1.f - sin2)};
}

float fifthPower(float x) { return sqr(sqr(x)) * x; }

}  // namespace

Vec3 BlinnDistribution::sample(Vec2 u) const {
  const float phi = 2.f * kPi * u.y;
  return fromPower(std::cos(phi), std::sin(phi), u.x, e_);
}

Vec3 AnisotropicDistribution::sample(Vec2 u) const {
  // tan(phi) = sqrt((ex+1)/(ey+1)) tan(psi), psi uniform: a circle squeezed along the axes.
  const float psi = 2.f * kPi * u.x;
  const float x = std::cos(psi) / std::sqrt(ex_ + 1.f), y = std::sin(psi) / std::sqrt(ey_ + 1.f);
  const float inverseLength = 1.f / std::sqrt(x * x + y * y);
  const float cosPhi = x * inverseLength, sinPhi = y * inverseLength;
  return fromPower(cosPhi, sinPhi, u.y, ex_ * cosPhi * cosPhi + ey_ * sinPhi * sinPhi);
}

std::optional<Vec3> reflectAbout(const Vec3& wo, Vec3 wh) {
  if (wo.z < 0.f) wh = -wh;
  const float cosine = dot(wo, wh);
  if (!(cosine > 0.f)) return std::nullopt;
  const Vec3 wi = 2.f * cosine * wh - wo;
  if (!sameHemisphere(wo, wi)) return std::nullopt;
  return wi;
}

FresnelBlendLobe::FresnelBlendLobe(const Rgb& rd, const Rgb& rs,
                                   const AnisotropicDistribution& distribution)
    : Lobe(kReflection | kGlossy),
      diffuse_(28.f / (23.f * kPi) * rd * max(Rgb(1.f) - rs, 0.f)),
      rs_(rs),
      distribution_(distribution) {}

BsdfValue FresnelBlendLobe::evaluate(const Vec3& wo, const Vec3& wi) const {
  const float o = absCosTheta(wo), i = absCosTheta(wi), larger = std::max(o, i);
  const auto h = halfVector(wo, wi);
  if (!h || !(larger > 0.f)) return {};
  const float power = distribution_.power(h->wh);
  const Rgb schlick = rs_ + fifthPower(1.f - std::min(h->cosine, 1.f)) * (Rgb(1.f) - rs_);
  const Rgb base =
      diffuse_ * ((1.f - fifthPower(1.f - .5f * i)) * (1.f - fifthPower(1.f - .5f * o)));
  BsdfValue value;
  value.f = base + schlick * (distribution_.dFactor() * power / (4.f * h->cosine * larger));
  if (sameHemisphere(wo, wi))
    value.pdf = .5f * (i * kInvPi + distribution_.pdfFactor() * power / (4.f * h->cosine));
  return value;
}

std::optional<BsdfSample> FresnelBlendLobe::sample(const Vec3& wo, Vec2 u) const {
  Vec3 wi;
  if (u.x < .5f) {
    wi = sampleCosineHemisphere({2.f * u.x, u.y});
    if (wo.z < 0.f) wi.z = -wi.z;
  } else {
    const auto reflected = reflectAbout(wo, distribution_.sample({2.f * (u.x - .5f), u.y}));
    if (!reflected) return std::nullopt;
    wi = *reflected;
  }
  const BsdfValue value = evaluate(wo, wi);
  if (!(value.pdf > 0.f)) return std::nullopt;
  return BsdfSample{value.f, wi, value.pdf, flags()};
}

}  // namespace brume
