// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/medium_along_ray.h"
#include "core/registry.h"
#include "volumes/box_volume.h"

namespace brume {

namespace {

/// Density that falls exponentially with height, in a box:
///   density(p) = a exp(-b h),  h = dot(p - pMin, updir)          [volume space]
/// Along a ray h is linear in t, so with k = b dh/dt and rho0 the density at t0
///   Int_t0^t density = rho0 (t - t0) (1 - exp(-k (t - t0))) / (k (t - t0)),
/// stable for k -> 0, and t - t0 = -log(1 - k target / rho0) / k.
/// Source: PBRT-v2. Test: volumes_test.
class Exponential final : public BoxVolume {
 public:
  struct Params : VolumeParams {
    float a = 1, b = 1;
    Vec3 updir{0, 1, 0};
    void visit(ParamVisitor& v) {
      VolumeParams::visit(v);
      v(a, "a", kNonNegative, Unit::None, "density at the bottom of the box");
      v(b, "b", kAnyFloat, Unit::InverseLength,
        "rate at which the density falls with height, per unit of volume space; negative: rises");
      v.vector(updir, "updir", Unit::None, "direction of height, in volume space");
    }
  };

  Exponential(const Params& params, const FactoryContext& context)
      : BoxVolume(params, context), a_(params.a), b_(params.b) {
    const auto up = tryNormalize(params.updir);
    if (!up) throw SceneError(context.where, "\"updir\" must not be the zero vector");
    up_ = normalize(Vec3d(params.updir));

    // The density is monotone along up, so its extremes lie in corners.
    for (int i = 0; i < 8; ++i) {
      const Vec3d corner(i & 1 ? boxHi().x : boxLo().x, i & 2 ? boxHi().y : boxLo().y,
                         i & 4 ? boxHi().z : boxLo().z);
      maxDensity_ = std::max(maxDensity_, density(corner));
    }
    if (!(maxDensity_ <= std::numeric_limits<float>::max()))
      throw SceneError(context.where,
                       fmt::format("the density a exp(-b h) overflows inside the box: a = {:g}, "
                                   "b = {:g}",
                                   params.a, params.b));
    checkCoefficients(context);
  }

 protected:
  double density(const Vec3d& p) const override {
    return a_ == 0 ? 0 : a_ * std::exp(-b_ * dot(p - boxLo(), up_));
  }
  double maxDensity() const override { return maxDensity_; }
  double integral(const LocalRay& ray, IntervalD range) const override {
    const double length = range.t1 - range.t0;
    // From the denser end: the other density may underflow and its exponent overflow.
    const double k = rate(ray);
    const double start = density(ray.o + ray.d * (k >= 0 ? range.t0 : range.t1));
    return start * length * exponentialMean(std::abs(k) * length);
  }
  std::optional<double> invert(const LocalRay& ray, IntervalD range, double target) const override {
    const double total = integral(ray, range);
    if (target > total) return std::nullopt;
    const double k = rate(ray), length = range.t1 - range.t0;
    const double start = density(ray.o + ray.d * range.t0);
    if (k >= 0) return range.t0 + std::min(length, stretch(k, target / start));
    // Rising: forward, unless the density at the start underflows; then back from the end.
    if (start >= std::numeric_limits<double>::min())
      return range.t0 + std::min(length, std::log1p(-k * target / start) / -k);
    const double end = density(ray.o + ray.d * range.t1);
    return range.t1 - std::min(length, stretch(-k, (total - target) / end));
  }
  void appendDensity(const LocalRay& ray, IntervalD range,
                     std::vector<MediumPiece>& pieces) const override {
    if (a_ == 0) return;
    const double k = rate(ray);
    pieces.push_back({MediumPiece::Form::Exponential,
                      range.t0,
                      range.t1,
                      {density(ray.o + ray.d * (k >= 0 ? range.t0 : range.t1)), k},
                      nullptr});
  }

  // The density is a product of three exponentials, one along each axis of the box.
  double totalDensity() const override {
    double product = a_ * std::exp(-b_ * exponentOfPeak());
    for (int i = 0; i < 3; ++i) {
      const double length = boxHi()[i] - boxLo()[i];
      product *= length * exponentialMean(std::abs(b_ * up_[i]) * length);
    }
    return product;
  }
  Vec3d sampleDensity(Rng& rng) const override {
    Vec3d p;
    for (int i = 0; i < 3; ++i) {
      const double length = boxHi()[i] - boxLo()[i], k = std::abs(b_ * up_[i]);
      // From the denser end; the exponential distribution cut off at the other one.
      const double u = rng.uniformDouble();
      const double s = k * length > 0 ? -std::log1p(u * std::expm1(-k * length)) / k : u * length;
      p[i] = std::clamp(b_ * up_[i] >= 0 ? boxLo()[i] + s : boxHi()[i] - s, boxLo()[i], boxHi()[i]);
    }
    return p;
  }

 private:
  /// h where the density is largest.
  double exponentOfPeak() const {
    double h = 0;
    for (int i = 0; i < 3; ++i)
      if (b_ * up_[i] < 0) h += up_[i] * (boxHi()[i] - boxLo()[i]);
    return h;
  }
  double rate(const LocalRay& ray) const { return b_ * dot(ray.d, up_); }
  /// The s with Int_0^s exp(-k u) du = x, for k >= 0: -log(1 - k x) / k.
  static double stretch(double k, double x) {
    const double kx = k * x;
    if (kx >= 1) return std::numeric_limits<double>::infinity();
    return kx == 0 ? x : x * (-std::log1p(-kx) / kx);
  }

  double a_, b_;
  Vec3d up_;
  double maxDensity_ = 0;
};

const RegisterPlugin<Volume, Exponential> kRegistration{
    "exponential", Origin::PbrtV2, "box whose density falls exponentially with height"};

}  // namespace

}  // namespace brume
