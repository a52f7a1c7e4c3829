// SPDX-License-Identifier: Apache-2.0
#include "core/bsdf.h"

#include "core/error.h"
#include "core/rng.h"
#include "core/sampling.h"

namespace brume {

std::optional<BsdfSample> Lobe::sample(const Vec3& wo, Vec2 u) const {
  Vec3 wi = sampleCosineHemisphere(u);
  if (wo.z < 0.f) wi.z = -wi.z;
  const BsdfValue value = evaluate(wo, wi);
  if (!(value.pdf > 0.f)) return std::nullopt;
  return BsdfSample{value.f, wi, value.pdf, flags_};
}

float Lobe::pdf(const Vec3& wo, const Vec3& wi) const {
  return sameHemisphere(wo, wi) ? absCosTheta(wi) * kInvPi : 0.f;
}

void Bsdf::reset(const Vec3& ns, const Vec3& dpdu, const Vec3& ng) {
  // The bitangent first: the cross product in double is orthogonal to ns however near to parallel
  // the two are and however long dpdu is.
  const Vec3d bitangent = dpdu == Vec3(0) ? Vec3d(0) : cross(Vec3d(ns), Vec3d(dpdu));
  const double l2 = dot(bitangent, bitangent);
  if (l2 > 0 && std::isfinite(l2)) {
    frame_.z = ns;
    frame_.y = Vec3(bitangent * (1 / std::sqrt(l2)));
    frame_.x = cross(frame_.y, ns);
  } else {
    frame_ = Frame::fromZ(ns);
  }
  ng_ = ng;
  presentScale_ = Rgb(1.f);
  count_ = 0;
  hasSpecular_ = false;
}

void Bsdf::checkRoom() const { BRUME_CHECK(count_ < kMaxLobes); }

int Bsdf::countMatching(LobeFlags accepted) const {
  int n = 0;
  for (int i = 0; i < count_; ++i) n += lobe(i).matches(accepted) ? 1 : 0;
  return n;
}

namespace {

/// Where wi lies seen from wo by the geometric normal; 0 when either is exactly grazing. Signs are
/// compared because the product of two small cosines may underflow.
LobeFlags geometricSide(const Vec3& wo, const Vec3& wi, const Vec3& ng) {
  const float o = dot(wo, ng), i = dot(wi, ng);
  if (o == 0.f || i == 0.f) return 0;
  return (o > 0.f) == (i > 0.f) ? kReflection : kTransmission;
}

}  // namespace

Rgb Bsdf::f(const Vec3& wo, const Vec3& wi, LobeFlags accepted) const {
  const LobeFlags side = geometricSide(wo, wi, ng_);
  const Vec3 o = frame_.toLocal(wo), i = frame_.toLocal(wi);
  Rgb sum;
  for (int k = 0; k < count_; ++k) {
    const Lobe& l = lobe(k);
    if (l.matches(accepted) && (l.flags() & side)) sum += scale_[k] * l.f(o, i);
  }
  return sum;
}

std::optional<Rgb> Bsdf::constantReflection(LobeFlags accepted) const {
  Rgb sum;
  for (int k = 0; k < count_; ++k) {
    const Lobe& l = lobe(k);
    if (!l.matches(accepted)) continue;
    if (!l.isConstant() || !(l.flags() & kReflection)) return std::nullopt;
    sum += scale_[k] * l.f({}, {});
  }
  return sum;
}

Bsdf::Choice Bsdf::choiceOf(const Vec3& wo, LobeFlags accepted) const {
  Choice choice;
  for (int k = 0; k < count_; ++k)
    if (lobe(k).matches(accepted)) choice.lobes[static_cast<std::size_t>(choice.count++)] = k;
  const auto n = static_cast<std::size_t>(choice.count);
  float sum = 0;
  if (hasSpecular_ && n > 1 && (accepted & kSpecular))
    for (std::size_t j = 0; j < n; ++j) {
      const int k = choice.lobes[j];
      choice.probability[j] = std::max(0.f, scale_[k].average() * lobe(k).weight(wo));
      sum += choice.probability[j];
    }
  for (std::size_t j = 0; j < n; ++j)
    choice.probability[j] = sum > 0 ? choice.probability[j] / sum : 1 / static_cast<float>(n);
  return choice;
}

float Bsdf::pdf(const Vec3& wo, const Vec3& wi, LobeFlags accepted) const {
  const Vec3 o = frame_.toLocal(wo), i = frame_.toLocal(wi);
  const Choice choice = choiceOf(o, accepted);
  float pdf = 0;
  for (std::size_t j = 0; j < static_cast<std::size_t>(choice.count); ++j)
    pdf += choice.probability[j] * lobe(choice.lobes[j]).pdf(o, i);
  return pdf;
}

BsdfValue Bsdf::evaluate(const Vec3& wo, const Vec3& wi, LobeFlags accepted) const {
  const LobeFlags side = geometricSide(wo, wi, ng_);
  const Vec3 o = frame_.toLocal(wo), i = frame_.toLocal(wi);
  const Choice choice = choiceOf(o, accepted);
  Rgb f;  // apart from pdf: a struct of both sums stays in memory and stalls on its own stores
  float pdf = 0;
  for (std::size_t j = 0; j < static_cast<std::size_t>(choice.count); ++j) {
    const Lobe& l = lobe(choice.lobes[j]);
    const BsdfValue value = l.evaluate(o, i);
    pdf += choice.probability[j] * value.pdf;
    if (l.flags() & side) f += scale_[choice.lobes[j]] * value.f;
  }
  return {f, pdf};
}

std::optional<BsdfSample> Bsdf::sample(const Vec3& wo, float uLobe, Vec2 u,
                                       LobeFlags accepted) const {
  const Vec3 o = frame_.toLocal(wo);
  const Choice choice = choiceOf(o, accepted);
  if (choice.count == 0) return std::nullopt;
  const auto n = static_cast<std::size_t>(choice.count);
  std::size_t chosen = 0;
  float below = 0;
  while (chosen + 1 < n && uLobe >= below + choice.probability[chosen])
    below += choice.probability[chosen++];
  const int c = choice.lobes[chosen];

  const std::optional<BsdfSample> s = lobe(c).sample(o, u);
  if (!s) return std::nullopt;
  const Vec3 wi = normalize(frame_.fromLocal(s->wi));
  Rgb f = s->f * scale_[c];
  float pdf = choice.probability[chosen] * s->pdf;
  if (s->isSpecular()) {
    // A specular f is divided by the cosine: by the one that the caller multiplies with, or
    // rounding would make fireflies at grazing angles.
    const float cosine = absDot(wi, frame_.z);
    if (!(cosine > 0.f)) return std::nullopt;
    f *= absCosTheta(s->wi) / cosine;
  } else {
    // Everything that the other lobes would do with the same direction.
    const LobeFlags side = geometricSide(wo, wi, ng_);
    if (!(s->flags & side)) f = Rgb();
    for (std::size_t j = 0; j < n; ++j) {
      if (j == chosen) continue;
      const Lobe& l = lobe(choice.lobes[j]);
      const BsdfValue value = l.evaluate(o, s->wi);
      pdf += choice.probability[j] * value.pdf;
      if (l.flags() & side) f += scale_[choice.lobes[j]] * value.f;
    }
  }
  if (f.isBlack() || !(pdf > 0)) return std::nullopt;
  return BsdfSample{f, wi, pdf, s->flags, s->eta};
}

Rgb Bsdf::reflectance(const Vec3& wo, LobeFlags accepted, int sqrtSamples) const {
  const Vec3 o = frame_.toLocal(wo);
  const float cell = 1.f / static_cast<float>(sqrtSamples);
  Rgb sum;
  for (int k = 0; k < count_; ++k) {
    const Lobe& l = lobe(k);
    if (!l.matches(accepted)) continue;
    Rng rng(hashIntegers(k));  // the same jitter for every point: no noise between neighbours
    Rgb lobeSum;
    for (int y = 0; y < sqrtSamples; ++y)
      for (int x = 0; x < sqrtSamples; ++x) {
        const Vec2 u = (Vec2(x, y) + rng.uniform2()) * cell;
        const auto s =
            l.sample(o, {std::min(u.x, kOneMinusEpsilon), std::min(u.y, kOneMinusEpsilon)});
        if (s) lobeSum += s->f * (absCosTheta(s->wi) / s->pdf);
      }
    sum += scale_[k] * lobeSum * (cell * cell);
  }
  return sum;
}

}  // namespace brume
