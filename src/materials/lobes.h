// SPDX-License-Identifier: Apache-2.0
// Diffuse and specular lobes, Fresnel's formulas, and what every material does with its textures.
// Directions are in the lobe's frame: z is the shading normal, cos is w.z. A lobe does not know the
// geometric side of the surface (Bsdf does): f of a diffuse or glossy lobe is even in cos.
#pragma once

#include "core/bsdf.h"
#include "core/interaction.h"
#include "core/params.h"
#include "core/texture.h"

namespace brume {

/// A reflectance from a constant or texture: never negative, not bounded above (as PBRT-v2).
inline Rgb reflectanceAt(const RgbSlot& slot, const SurfaceInteraction& at) {
  return max(slot.evaluate(at.texture), 0.f);
}
/// A non-negative number from a constant or texture.
inline float nonNegativeAt(const FloatSlot& slot, const SurfaceInteraction& at) {
  return std::max(slot.evaluate(at.texture), 0.f);
}
/// Whether a reflectance can be other than black anywhere.
inline bool canBeNonBlack(const RgbSlot& slot) {
  return !slot.isConstant() || !slot.constant.isBlack();
}
inline void declareBumpMap(ParamVisitor& v, std::optional<FloatSlot>& bumpmap) {
  v(bumpmap, "bumpmap", kAnyFloat, Unit::Length,
    "displacement along the normal that shading follows; none by default");
}
inline const FloatSlot* orNull(const std::optional<FloatSlot>& slot) {
  return slot ? &*slot : nullptr;
}
/// The largest index of refraction, eta or k accepted: its square is still a float.
inline constexpr float kMaxIndex = 1e6f;

/// An index of refraction, eta or k from a constant or texture.
inline float indexAt(const FloatSlot& slot, const SurfaceInteraction& at) {
  return std::min(nonNegativeAt(slot, at), kMaxIndex);
}
inline Rgb indexAt(const RgbSlot& slot, const SurfaceInteraction& at) {
  return min(reflectanceAt(slot, at), kMaxIndex);
}

/// Unpolarised reflectance of a dielectric interface for light with cosine cosI on the side of
/// etaI; a negative cosine comes from the other side. 1 beyond the critical angle.
inline float fresnelDielectric(float cosI, float etaI, float etaT) {
  if (!(cosI > 0.f)) std::swap(etaI, etaT);
  cosI = std::min(std::abs(cosI), 1.f);
  const float ratio = etaI / etaT;
  // Snell's law for cosines: exact for equal indices, however grazing.
  const float cos2T = (1.f - ratio * ratio) + ratio * ratio * (cosI * cosI);
  if (!(cos2T > 0.f)) return 1.f;
  const float cosT = std::sqrt(cos2T);
  const float parallel = (etaT * cosI - etaI * cosT) / (etaT * cosI + etaI * cosT);
  const float perpendicular = (etaI * cosI - etaT * cosT) / (etaI * cosI + etaT * cosT);
  return .5f * (parallel * parallel + perpendicular * perpendicular);
}

/// Approximate reflectance of a conductor with index eta and absorption k, |cos| of incidence.
/// Source: Pharr, Humphreys 2010, section 8.2 (exact for eta^2 + k^2 >> 1).
inline Rgb fresnelConductor(float absCosI, const Rgb& eta, const Rgb& k) {
  const float c = absCosI, c2 = c * c;
  const Rgb n2 = eta * eta + k * k, twoNc = eta * (2.f * c);
  const Rgb parallel = (n2 * c2 - twoNc + Rgb(1.f)) / (n2 * c2 + twoNc + Rgb(1.f));
  Rgb perpendicular;  // 0/0 for a vacuum at grazing incidence counts as the limit 1
  for (int i = 0; i < 3; ++i) {
    const float denominator = n2[i] + twoNc[i] + c2;
    perpendicular[i] = denominator > 0.f ? (n2[i] - twoNc[i] + c2) / denominator : 1.f;
  }
  return (parallel + perpendicular) * .5f;
}

/// Fresnel terms as types, so that lobes need no second virtual call.
struct FresnelNone {
  Rgb operator()(float) const { return Rgb(1.f); }
};
struct FresnelDielectric {
  float etaI = 1, etaT = 1;
  Rgb operator()(float cosI) const { return Rgb(fresnelDielectric(cosI, etaI, etaT)); }
};
struct FresnelConductor {
  Rgb eta, k;
  Rgb operator()(float cosI) const { return fresnelConductor(std::abs(cosI), eta, k); }
};

/// Lambert: f = R / pi.
class LambertLobe final : public Lobe {
 public:
  explicit LambertLobe(const Rgb& reflectance)
      : Lobe(kReflection | kDiffuse), f_(reflectance * kInvPi) {}
  Rgb f(const Vec3&, const Vec3&) const override { return f_; }
  bool isConstant() const override { return true; }
  BsdfValue evaluate(const Vec3& wo, const Vec3& wi) const override {
    return {f_, sameHemisphere(wo, wi) ? absCosTheta(wi) * kInvPi : 0.f};
  }

 private:
  Rgb f_;
};

/// Rough diffuse surface of Gaussian facets with standard deviation sigma:
///   f = R/pi (A + B max(0, cos(phi_i - phi_o)) sin(alpha) tan(beta)),
///   A = 1 - s2 / (2 (s2 + .33)), B = .45 s2 / (s2 + .09), s2 = sigma^2 [rad^2]
/// Source: Oren, Nayar 1994. sin(alpha) sin(beta) = sin_i sin_o and cos(beta) is the larger cosine,
/// so the second term is B max(0, wi.x wo.x + wi.y wo.y) / max(cos_i, cos_o).
class OrenNayarLobe final : public Lobe {
 public:
  OrenNayarLobe(const Rgb& reflectance, float sigmaDegrees);
  Rgb f(const Vec3& wo, const Vec3& wi) const override;

 private:
  Rgb rOverPi_;
  float a_, b_;
};

/// A reflecting lobe turned to the other side of the surface: f(wo, wi) = reflecting(wo, wi*), wi*
/// the mirror image of wi in the surface.
template <class Reflecting>
class MirroredLobe final : public Lobe {
 public:
  explicit MirroredLobe(const Reflecting& reflecting)
      : Lobe(reflecting.flags() ^ (kReflection | kTransmission)), reflecting_(reflecting) {}
  Rgb f(const Vec3& wo, const Vec3& wi) const override { return reflecting_.f(wo, mirror(wi)); }
  float pdf(const Vec3& wo, const Vec3& wi) const override {
    return reflecting_.pdf(wo, mirror(wi));
  }
  BsdfValue evaluate(const Vec3& wo, const Vec3& wi) const override {
    return reflecting_.evaluate(wo, mirror(wi));
  }
  std::optional<BsdfSample> sample(const Vec3& wo, Vec2 u) const override {
    std::optional<BsdfSample> s = reflecting_.sample(wo, u);
    if (s) {
      s->wi = mirror(s->wi);
      s->flags = flags();
    }
    return s;
  }

 private:
  static Vec3 mirror(const Vec3& w) { return {w.x, w.y, -w.z}; }
  Reflecting reflecting_;
};

/// Perfect mirror: weight R F(cos).
template <class Fresnel>
class SpecularReflectionLobe final : public Lobe {
 public:
  SpecularReflectionLobe(const Rgb& reflectance, const Fresnel& fresnel)
      : Lobe(kReflection | kSpecular), reflectance_(reflectance), fresnel_(fresnel) {}
  Rgb f(const Vec3&, const Vec3&) const override { return Rgb(); }
  float pdf(const Vec3&, const Vec3&) const override { return 0.f; }
  std::optional<BsdfSample> sample(const Vec3& wo, Vec2) const override {
    const float cosine = absCosTheta(wo);
    if (!(cosine >= std::numeric_limits<float>::min())) return std::nullopt;
    return BsdfSample{
        reflectance_ * fresnel_(cosTheta(wo)) / cosine, {-wo.x, -wo.y, wo.z}, 1.f, flags()};
  }
  float weight(const Vec3& wo) const override {
    return (reflectance_ * fresnel_(cosTheta(wo))).average();
  }

 private:
  Rgb reflectance_;
  Fresnel fresnel_;
};

/// Refraction between etaI (on the side of the normal) and etaT: weight T (1 - F). As in PBRT-v2,
/// radiance is not scaled by the squared ratio of the indices.
class SpecularTransmissionLobe final : public Lobe {
 public:
  SpecularTransmissionLobe(const Rgb& transmittance, float etaI, float etaT)
      : Lobe(kTransmission | kSpecular), transmittance_(transmittance), etaI_(etaI), etaT_(etaT) {}
  Rgb f(const Vec3&, const Vec3&) const override { return Rgb(); }
  float pdf(const Vec3&, const Vec3&) const override { return 0.f; }
  std::optional<BsdfSample> sample(const Vec3& wo, Vec2 u) const override;
  float weight(const Vec3& wo) const override;

 private:
  Rgb transmittance_;
  float etaI_, etaT_;
};

}  // namespace brume
