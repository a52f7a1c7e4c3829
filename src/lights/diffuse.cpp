// SPDX-License-Identifier: Apache-2.0
#include "core/light.h"
#include "core/registry.h"
#include "core/sampling.h"

namespace brume {
namespace {

/// A shape that emits radiance L evenly on the side of its normal, in all directions. Sampled by
/// the shape, per solid angle. Power pi A L. "area" is a second name. Test: light_test.
class DiffuseAreaLight final : public AreaLight {
 public:
  struct Params {
    Rgb L{1.f}, scale{1.f};
    int nsamples = 1;

    void visit(ParamVisitor& v) {
      v(L, "L", kAnyFloat, Unit::Radiance, "emitted radiance");
      v(scale, "scale", kAnyFloat, Unit::None, "multiplies L");
      v(nsamples, "nsamples", kPositiveInt, Unit::Samples,
        "shadow rays per point for \"directlighting\"");
    }
  };

  DiffuseAreaLight(const Params& params, const FactoryContext& context)
      : shape_(*context.shape),
        L_(params.L * params.scale),
        sampleCount_(context.quick ? std::max(1, params.nsamples / 4) : params.nsamples) {
    if (!shape_.canSample())
      throw SceneError(context.where, "this shape cannot be an area light: it cannot be sampled");
    area_ = shape_.area();
    bounds_ = shape_.bounds();
  }

  int sampleCount() const override { return sampleCount_; }
  std::optional<LightSample> sampleLi(const Vec3& p, Vec2 u) const override {
    const std::optional<ShapeSample> point = shape_.sampleSolidAngle(p, u);
    if (!point || !(point->pdf > 0)) return std::nullopt;
    const Vec3d d = Vec3d(point->p) - Vec3d(p);
    const double distance = length(d);
    if (!(distance > 0)) return std::nullopt;
    LightSample sample;
    sample.wi = Vec3(d * (1 / distance));
    if (!(dot(point->n, sample.wi) < 0)) return std::nullopt;
    sample.L = L_;
    sample.pdf = point->pdf;
    sample.distance = static_cast<float>(distance);
    sample.p = point->p;
    sample.pError = point->pError;
    sample.n = point->n;
    return sample;
  }
  float pdfLiAt(const Vec3& ref, const Vec3& wi, const Vec3& hitPoint,
                const Vec3& hitNormal) const override {
    return shape_.pdfSolidAngle(ref, wi, hitPoint, hitNormal);
  }
  Rgb L(const Vec3&, const Vec3& n, Vec2, const Vec3& w) const override {
    return dot(n, w) > 0 ? L_ : Rgb();
  }
  Rgb power() const override { return L_ * (kPi * area_); }
  /// L times a solid angle of about A / d^2, never more than a hemisphere: that of a disk of area A
  /// seen along its axis, to first order at both ends.
  float importance(const Bounds3& region) const override {
    const float perDistance = area_ * inverseSquareTo(region);
    return lightWeight(L_) * 2 * kPi / (1 + 2 * kPi / perDistance);
  }
  std::optional<LightBounds> bounds() const override {
    return LightBounds{bounds_, shape_.normals(), 0, double{lightWeight(L_)} * double{area_}};
  }
  std::optional<Vec3> position() const override { return bounds_.center(); }
  float extent() const override { return bounds_.radius(); }
  std::optional<LightEmission> sampleEmission(const Ball& target,
                                              const EmissionUniforms& u) const override;
  Rgb powerToward(const Ball& target) const override;

 private:
  /// 1/d^2 between the region and the point of the shape's bounds that is nearest to it.
  float inverseSquareTo(const Bounds3& region) const {
    return boundedInverseSquare(max(bounds_.lo, min(bounds_.hi, region.center())), region);
  }

  const Shape& shape_;
  Rgb L_;
  int sampleCount_;
  float area_ = 0;
  Bounds3 bounds_;
};

/// 1 - cos of the cone below which a target fills a small part of the hemisphere.
constexpr float kSmall = 0.25f;

/// A point by area and a cosine-distributed direction, or one towards a target that fills a small
/// part of the hemisphere.
std::optional<LightEmission> DiffuseAreaLight::sampleEmission(const Ball& target,
                                                              const EmissionUniforms& u) const {
  const ShapeSample at = shape_.sampleArea(u.point);
  if (!(at.pdf > 0)) return std::nullopt;
  const auto start = [&](const Vec3& w) { return offsetRayOrigin(at.p, at.pError, at.n, w); };
  if (oneMinusCosSeen(at.p, target) < kSmall) {
    const AimedDirection aimed = aimAt(target, at.p, u.direction);
    const float cosine = dot(aimed.w, at.n);
    if (!(cosine > 0)) return std::nullopt;
    return LightEmission{start(aimed.w), aimed.w, L_ * (cosine / (at.pdf * aimed.pdf))};
  }
  const Vec3 w = Frame::fromZ(at.n).fromLocal(sampleCosineHemisphere(u.direction));
  return LightEmission{start(w), w, L_ * (kPi / at.pdf)};
}

/// The mean over a grid of points; of a target that sinks below a point's horizon, about what is
/// left.
Rgb DiffuseAreaLight::powerToward(const Ball& target) const {
  constexpr int kPerAxis = 4;
  float sum = 0;
  for (int i = 0; i < kPerAxis * kPerAxis; ++i) {
    const Vec2 u = (Vec2(i % kPerAxis, i / kPerAxis) + Vec2(0.5f)) * (1.f / kPerAxis);
    const ShapeSample at = shape_.sampleArea(u);
    if (!(at.pdf > 0)) continue;
    const float oneMinusCos = oneMinusCosSeen(at.p, target);
    if (oneMinusCos >= kSmall) {
      sum += kPi / at.pdf;
      continue;
    }
    const auto cosine =
        static_cast<float>(dot(normalize(Vec3d(target.center) - Vec3d(at.p)), Vec3d(at.n)));
    const float sine = std::sqrt(oneMinusCos * (2 - oneMinusCos));  // of the cone's half-angle
    const float seen = cosine >= sine ? cosine : 0.25f * std::max(0.f, cosine + sine);
    sum += 2 * kPi * oneMinusCos * seen / at.pdf;
  }
  return L_ * (sum / (kPerAxis * kPerAxis));
}

const RegisterPlugin<AreaLight, DiffuseAreaLight> kRegistration{"diffuse", Origin::PbrtV2,
                                                                "shape that emits evenly"};
const RegisterPlugin<AreaLight, DiffuseAreaLight> kAlias{"area", Origin::PbrtV2,
                                                         "the same as \"diffuse\""};

}  // namespace
}  // namespace brume
