// SPDX-License-Identifier: Apache-2.0
#include "materials/lobes.h"

namespace brume {

OrenNayarLobe::OrenNayarLobe(const Rgb& reflectance, float sigmaDegrees)
    : Lobe(kReflection | kDiffuse), rOverPi_(reflectance * kInvPi) {
  const float s2 = sqr(radians(sigmaDegrees));
  a_ = 1.f - s2 / (2.f * (s2 + .33f));
  b_ = .45f * s2 / (s2 + .09f);
}

Rgb OrenNayarLobe::f(const Vec3& wo, const Vec3& wi) const {
  const float larger = std::max(absCosTheta(wo), absCosTheta(wi));
  if (!(larger > 0.f)) return Rgb();
  const float azimuthal = std::max(0.f, wi.x * wo.x + wi.y * wo.y);
  return rOverPi_ * (a_ + b_ * azimuthal / larger);
}

std::optional<BsdfSample> SpecularTransmissionLobe::sample(const Vec3& wo, Vec2) const {
  const bool fromSideOfNormal = cosTheta(wo) > 0.f;
  const float etaI = fromSideOfNormal ? etaI_ : etaT_;
  const float etaT = fromSideOfNormal ? etaT_ : etaI_;
  const float ratio = etaI / etaT;
  const float cos2T = (1.f - ratio * ratio) + ratio * ratio * sqr(cosTheta(wo));
  if (!(cos2T >= std::numeric_limits<float>::min())) return std::nullopt;  // total reflection

  const float cosT = std::sqrt(cos2T);
  const Vec3 wi{-ratio * wo.x, -ratio * wo.y, fromSideOfNormal ? -cosT : cosT};
  const float transmitted = 1.f - fresnelDielectric(cosTheta(wo), etaI_, etaT_);
  return BsdfSample{transmittance_ * (transmitted / cosT), wi, 1.f, flags(), ratio};
}

float SpecularTransmissionLobe::weight(const Vec3& wo) const {
  return transmittance_.average() * (1.f - fresnelDielectric(cosTheta(wo), etaI_, etaT_));
}

}  // namespace brume
