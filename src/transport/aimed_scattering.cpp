// SPDX-License-Identifier: Apache-2.0
#include "transport/aimed_scattering.h"

#include "core/sampling.h"

namespace brume {
namespace {

/// 1 - cos of the half angle above which a ball needs no aiming at: 41 degrees, a seventh of the
/// cosine-weighted hemisphere when it is straight above.
constexpr float kLargeCone = 0.25f;

/// Density of directions in the cone around the ball; 1 - cos without cancellation.
float conePdf(const Vec3& axis, float oneMinusCos, const Vec3& w) {
  const Vec3d difference = Vec3d(w) - Vec3d(axis);
  return dot(difference, difference) / 2 <= double{oneMinusCos} ? coneUniformPdf(oneMinusCos) : 0;
}

}  // namespace

std::optional<BsdfSample> sampleTowards(const Bsdf& bsdf, const SurfaceInteraction& at,
                                        const Ball& ball, float uLobe, Vec2 u) {
  const float oneMinusCos = ball.radius > 0 ? oneMinusCosSeen(at.p, ball) : 2.f;
  if (oneMinusCos > kLargeCone || bsdf.isSpecularOnly()) return bsdf.sample(at.wo, uLobe, u);
  const Vec3 axis(normalize(Vec3d(ball.center) - Vec3d(at.p)));
  if (uLobe >= kAimedShare) {
    auto sample = bsdf.sample(at.wo, (uLobe - kAimedShare) / (1 - kAimedShare), u);
    if (!sample) return sample;
    sample->pdf *= 1 - kAimedShare;
    if (!sample->isSpecular()) sample->pdf += kAimedShare * conePdf(axis, oneMinusCos, sample->wi);
    return sample;
  }
  const AimedDirection aimed = aimAt(ball, at.p, u);
  const BsdfValue value = bsdf.evaluate(at.wo, aimed.w);
  if (value.f.isBlack()) return std::nullopt;
  const Vec3& ng = bsdf.geometricNormal();
  const bool isReflected = (dot(at.wo, ng) > 0) == (dot(aimed.w, ng) > 0);
  const float pdf = (1 - kAimedShare) * value.pdf + kAimedShare * aimed.pdf;
  return BsdfSample{value.f, aimed.w, pdf, isReflected ? kReflection : kTransmission};
}

}  // namespace brume
