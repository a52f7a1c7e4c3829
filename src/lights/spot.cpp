// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/light.h"
#include "core/log.h"
#include "core/registry.h"

namespace brume {
namespace {

/// 1 - cos of an angle in degrees.
float oneMinusCos(float degrees) {
  return static_cast<float>(2 * sqr(std::sin(0.5 * static_cast<double>(degrees) * M_PI / 180)));
}

/// Point light in a cone around from -> to:
///   I(theta) = I for theta <= theta_s, I ((cos theta - cos theta_t) / (cos theta_s - cos
///   theta_t))^4 up to theta_t = coneangle, 0 beyond; theta_s = coneangle - conedeltaangle
/// Power 2 pi I (1 - cos theta_s + (cos theta_s - cos theta_t) / 5). Test: light_test.
class SpotLight final : public Light {
 public:
  struct Params {
    Rgb I{1.f}, scale{1.f};
    Vec3 from{0}, to{0, 0, 1};
    float coneangle = 30, conedeltaangle = 5;

    void visit(ParamVisitor& v) {
      v(I, "I", kAnyFloat, Unit::RadiantIntensity, "radiant intensity on the axis");
      v(scale, "scale", kAnyFloat, Unit::None, "multiplies I");
      v.point(from, "from", Unit::Length, "position");
      v.point(to, "to", Unit::Length, "a point on the axis");
      v(coneangle, "coneangle", Range<float>{0.f, 180.f, true}, Unit::Degrees,
        "angle between the axis and the border of the cone");
      v(conedeltaangle, "conedeltaangle", Range<float>{0.f, 180.f}, Unit::Degrees,
        "width of the falloff inside the border");
    }
  };

  SpotLight(const Params& params, const FactoryContext& context)
      : intensity_(params.I * params.scale), edge_(oneMinusCos(params.coneangle)) {
    const Transform lightToWorld =
        context.lightToWorld * lightFrame(params.from, params.to, context.where);
    worldToLight_ = lightToWorld.inverse();
    position_ = Vec3(Vec3d(lightToWorld.matrix()[3]));
    axis_ = Vec3(normalize(Vec3d(lightToWorld.matrix()[2])));
    hasScale_ = lightToWorld.hasScale();
    if (hasScale_)
      context.log->warning(context.where,
                           "the spot light's transform has a scale: its cone is "
                           "deformed, its intensity is not");
    // PBRT-v2 takes the cosine of the difference, whatever its sign.
    const float start = std::abs(params.coneangle - params.conedeltaangle);
    if (params.conedeltaangle > params.coneangle) {
      const std::string text = fmt::format("conedeltaangle {} is more than coneangle {}",
                                           params.conedeltaangle, params.coneangle);
      if (start > params.coneangle) throw SceneError(context.where, text);
      context.log->warning(context.where,
                           text + fmt::format(": the falloff begins at {} degrees", start));
    }
    falloffStart_ = oneMinusCos(start);
  }

  bool isDelta() const override { return true; }
  std::optional<LightSample> sampleLi(const Vec3& p, Vec2) const override {
    if (isClearlyOutside(p)) return std::nullopt;
    std::optional<LightSample> sample = samplePosition(p, position_);
    if (!sample) return sample;
    const float f = falloff(oneMinusCosTheta(worldToLight_.vector(-sample->wi)));
    if (f == 0) return std::nullopt;
    sample->L *= intensity_ * f;
    return sample;
  }
  Rgb power() const override { return intensity_ * (2 * kPi * emitted()); }
  float importance(const Bounds3& region) const override {
    // A cone deformed by a scale has no angle to test.
    const float f = hasScale_ ? 1 : falloff(smallestOneMinusCos(position_, axis_, region));
    return lightWeight(intensity_) * boundedInverseSquare(position_, region) * f;
  }
  std::optional<LightBounds> bounds() const override {
    LightBounds b = pointBounds(position_, lightWeight(intensity_));
    // A cone deformed by a scale has no angle.
    if (!hasScale_) {
      b.axes = DirectionCone::around(axis_);
      b.cosEmission = 1 - edge_;
    }
    return b;
  }
  std::optional<Vec3> position() const override { return position_; }
  Interval illuminated(const Ray& ray, Interval range) const override;
  std::optional<LightEmission> sampleEmission(const Ball& target,
                                              const EmissionUniforms& u) const override;
  Rgb powerToward(const Ball& target) const override {
    return intensity_ * (2 * kPi * std::min(emitted(), oneMinusCosSeen(position_, target)));
  }

 private:
  float falloff(float omc) const {
    if (omc >= edge_) return 0;
    if (omc <= falloffStart_) return 1;
    return sqr(sqr((edge_ - omc) / (edge_ - falloffStart_)));
  }

  /// Integral of the falloff over 1 - cos theta.
  float emitted() const { return falloffStart_ + (edge_ - falloffStart_) / 5; }
  /// 1 - cos theta in proportion to the falloff.
  float sampleFalloff(float u) const;

  /// Most points lie outside of a narrow cone: told without a root or a division.
  bool isClearlyOutside(const Vec3& p) const {
    const double c = (1 - double{edge_}) * (1 - 1e-5);
    if (hasScale_ || c <= 0) return false;
    const Vec3d d = Vec3d(p) - Vec3d(position_);
    const double m = dot(d, Vec3d(axis_));
    return m <= 0 || m * m < c * c * dot(d, d);
  }

  Rgb intensity_;
  float edge_, falloffStart_ = 0;  // 1 - cos of the two angles
  Transform worldToLight_;
  Vec3 position_, axis_;
  bool hasScale_ = false;
};

/// The part of the ray inside the cone: with p(t) from the apex, m = dot(p, axis) and c = cos
/// theta_t, the ends are roots of m^2 - c^2 |p|^2 with m > 0. A cone of less than a half space is
/// convex, so that the part is one interval.
Interval SpotLight::illuminated(const Ray& ray, Interval range) const {
  const double c = 1 - double{edge_};
  if (hasScale_ || c < 1e-3) return range;
  const Vec3d o = Vec3d(ray.o) - Vec3d(position_), d(ray.d), axis(axis_);
  const double mo = dot(o, axis), md = dot(d, axis);
  const double qa = md * md - c * c * dot(d, d), qb = mo * md - c * c * dot(o, d),
               qc = mo * mo - c * c * dot(o, o);
  const auto isInside = [&](double t) {
    const double m = mo + t * md;
    return m > 0 && qa * t * t + 2 * qb * t + qc > 0;
  };

  // The ends of the range and the roots inside it, in order, cut it into parts that are in or out.
  double cut[4] = {range.t0, range.t1, range.t1, range.t1};
  int n = 1;
  const auto add = [&](double t) {
    if (t > cut[0] && t < double{range.t1}) cut[n++] = t;
  };
  const double discriminant = qb * qb - qa * qc;
  if (discriminant >= 0) {
    const double q = -(qb + std::copysign(std::sqrt(discriminant), qb));
    if (qa != 0) add(q / qa);
    if (q != 0) add(qc / q);
  }
  if (n == 3 && cut[1] > cut[2]) std::swap(cut[1], cut[2]);
  cut[n] = double{range.t1};
  Interval lit{range.t1, range.t0};
  for (int i = 0; i < n; ++i) {
    if (!(cut[i] < cut[i + 1]) || !isInside(0.5 * (cut[i] + cut[i + 1]))) continue;
    // A little wider, so that rounding leaves nothing out.
    const double slack = 1e-6 * std::max(std::abs(cut[i]), std::abs(cut[i + 1]));
    lit.t0 = std::min(lit.t0, std::max(range.t0, static_cast<float>(cut[i] - slack)));
    lit.t1 = std::max(lit.t1, std::min(range.t1, static_cast<float>(cut[i + 1] + slack)));
  }
  return lit;
}

/// Over x = 1 - cos theta the falloff is 1 up to x_s, then ((x_e - x) / (x_e - x_s))^4: its
/// integral is x_s + (x_e - x_s) / 5 (1 - y^5) with y the base of the power.
float SpotLight::sampleFalloff(float u) const {
  const double width = double{edge_} - double{falloffStart_};
  const double target = double{u} * double{emitted()};
  if (target < double{falloffStart_} || !(width > 0)) return static_cast<float>(target);
  const double rest = std::max(0.0, 1 - 5 * (target - double{falloffStart_}) / width);
  return static_cast<float>(double{edge_} - width * std::pow(rest, 0.2));
}

/// In proportion to the intensity, with a constant power; evenly towards the target where that
/// spans a smaller solid angle than the cone, or where a scale deforms the cone.
std::optional<LightEmission> SpotLight::sampleEmission(const Ball& target,
                                                       const EmissionUniforms& u) const {
  const float seen = oneMinusCosSeen(position_, target);
  if (hasScale_ || seen < emitted()) {
    const AimedDirection aimed = aimAt(target, position_, u.direction);
    const float f = falloff(oneMinusCosTheta(worldToLight_.vector(aimed.w)));
    if (f == 0) return std::nullopt;
    return LightEmission{position_, aimed.w, intensity_ * (f / aimed.pdf)};
  }
  const float x = sampleFalloff(u.direction.x), sine = std::sqrt(x * std::max(0.f, 2 - x)),
              phi = 2 * kPi * u.direction.y;
  const Vec3 local(std::cos(phi) * sine, std::sin(phi) * sine, 1 - x);
  return LightEmission{position_, normalize(Frame::fromZ(axis_).fromLocal(local)), power()};
}

const RegisterPlugin<Light, SpotLight> kRegistration{"spot", Origin::PbrtV2,
                                                     "point light in a cone with a soft border"};

}  // namespace
}  // namespace brume
