// SPDX-License-Identifier: Apache-2.0
#include "volumes/box_volume.h"

#include <fmt/format.h>

#include "core/log.h"
#include "core/medium_along_ray.h"

namespace brume {

namespace {

/// As for shapes, so that squares of distances are finite.
constexpr float kLargestCoordinate = 1.8e18f;

/// Colours that were given as spectra can lie outside the RGB gamut; media cannot be negative.
Rgb withoutNegatives(const Rgb& c, std::string_view name, const Volume::FactoryContext& context) {
  if (c.minChannel() >= 0) return c;
  if (context.log)
    context.log->warning(context.where,
                         fmt::format("\"{}\" has a negative component: ({:g}, {:g}, {:g}); it is "
                                     "taken as 0",
                                     name, c.r, c.g, c.b));
  return max(c, 0.f);
}

/// The largest extinction and emission: their products with lengths and each other are finite.
constexpr double kLargestCoefficient = 1e30;

Vec3d transformed(const Mat4d& m, const Vec3& v, double w) {
  return Vec3d(m * glm::dvec4(Vec3d(v), w));
}

}  // namespace

void VolumeParams::visit(ParamVisitor& v) {
  v(sigma_a, "sigma_a", kAnyFloat, Unit::InverseLength,
    "absorption coefficient, per unit of world length whatever the transform");
  v(sigma_s, "sigma_s", kAnyFloat, Unit::InverseLength,
    "scattering coefficient, per unit of world length whatever the transform");
  v(Le, "Le", kAnyFloat, Unit::RadiancePerLength, "radiance added per unit of world length");
  v.point(p0, "p0", Unit::Length, "one corner of the box, in volume space");
  v.point(p1, "p1", Unit::Length, "the opposite corner");
  phase.visit(v);
}

BoxVolume::BoxVolume(const VolumeParams& params, const FactoryContext& context)
    : volumeToWorld_(context.volumeToWorld),
      lo_(min(params.p0, params.p1)),
      hi_(max(params.p0, params.p1)),
      unit_{withoutNegatives(params.sigma_a, "sigma_a", context),
            withoutNegatives(params.sigma_s, "sigma_s", context),
            withoutNegatives(params.Le, "Le", context)},
      phase_(makePhase(params.phase, context.where)) {
  isFlat_ = lo_.x == hi_.x || lo_.y == hi_.y || lo_.z == hi_.z;
  if (isFlat_ && context.log)
    context.log->warning(context.where,
                         "the box from \"p0\" to \"p1\" is flat: it holds no medium");
  const Bounds3 bounds = BoxVolume::bounds();
  if (!(maxComponent(max(abs(bounds.lo), abs(bounds.hi))) <= kLargestCoordinate))
    throw SceneError(context.where, "the volume reaches beyond a distance of 1.8e18");
}

void BoxVolume::checkCoefficients(const FactoryContext& context) const {
  const auto check = [&](const char* what, double coefficient) {
    const double largest = coefficient * maxDensity();
    if (!(largest <= kLargestCoefficient))
      throw SceneError(context.where, fmt::format("{} times the largest density is {:g}; more than "
                                                  "{:g} cannot be rendered",
                                                  what, largest, kLargestCoefficient));
  };
  for (int c = 0; c < 3; ++c) {
    check("\"sigma_a\" + \"sigma_s\"", double{unit_.sigma_a[c]} + double{unit_.sigma_s[c]});
    check("\"Le\"", double{unit_.Le[c]});
  }
}

Bounds3 BoxVolume::bounds() const { return volumeToWorld_.bounds({Vec3(lo_), Vec3(hi_)}); }

void BoxVolume::appendBoxes(std::vector<MediumBox>& boxes) const {
  if (isFlat_) return;
  MediumBox box;
  for (std::size_t face = 0; face < 6; ++face) {
    const int axis = static_cast<int>(face / 2);
    const bool isHigh = face % 2 == 1;
    Vec3 outward(0);
    outward[axis] = isHigh ? 1.f : -1.f;
    box.normal[face] = normalize(Vec3d(volumeToWorld_.normal(outward)));
    box.offset[face] = dot(box.normal[face], Vec3d(volumeToWorld_.point(Vec3(isHigh ? hi_ : lo_))));
  }
  boxes.push_back(box);
}

double BoxVolume::worldIntegral() const {
  if (isFlat_) return 0;
  const glm::dmat3 linear(volumeToWorld_.matrix());
  return totalDensity() * std::abs(dot(linear[0], cross(linear[1], linear[2])));
}

Vec3 BoxVolume::sampleEmission(Rng& rng) const {
  // In double: volume space may lie far from its own origin.
  return Vec3(Vec3d(volumeToWorld_.matrix() * glm::dvec4(sampleDensity(rng), 1)));
}

LocalRay BoxVolume::toLocal(const Ray& ray) const {
  const Mat4d& m = volumeToWorld_.inverseMatrix();
  return {transformed(m, ray.o, 1), transformed(m, ray.d, 0)};
}

std::optional<IntervalD> BoxVolume::clip(const LocalRay& ray, Interval range) const {
  if (isFlat_) return std::nullopt;
  IntervalD r{range.t0, range.t1};
  for (int a = 0; a < 3; ++a) {
    if (ray.d[a] == 0) {
      if (!(ray.o[a] >= lo_[a] && ray.o[a] <= hi_[a])) return std::nullopt;
      continue;
    }
    const double tLo = (lo_[a] - ray.o[a]) / ray.d[a];
    const double tHi = (hi_[a] - ray.o[a]) / ray.d[a];
    r.t0 = std::max(r.t0, std::min(tLo, tHi));
    r.t1 = std::min(r.t1, std::max(tLo, tHi));
  }
  if (!(r.t0 < r.t1)) return std::nullopt;
  return r;
}

std::optional<Interval> BoxVolume::intersect(const Ray& ray) const {
  const LocalRay local = toLocal(ray);
  auto range = clip(local, {0, ray.tMax});
  if (range) range = tighten(local, *range);
  if (!range) return std::nullopt;
  // Rounded outwards, so that nothing is lost; within (0, tMax).
  Interval r{static_cast<float>(range->t0), static_cast<float>(range->t1)};
  if (double{r.t0} > range->t0) r.t0 = std::nextafter(r.t0, 0.f);
  if (double{r.t1} < range->t1) r.t1 = std::nextafter(r.t1, kInfinity);
  r.t1 = std::min(r.t1, ray.tMax);
  if (r.isEmpty()) return std::nullopt;
  return r;
}

MediumCoefficients BoxVolume::at(const Vec3& p) const {
  if (isFlat_) return {};
  const Vec3d local = transformed(volumeToWorld_.inverseMatrix(), p, 1);
  for (int a = 0; a < 3; ++a)
    if (!(local[a] >= lo_[a] && local[a] <= hi_[a])) return {};
  return unit_ * static_cast<float>(density(local));
}

Rgb BoxVolume::majorant() const { return unit_.sigma_t() * static_cast<float>(maxDensity()); }

Rgb BoxVolume::opticalDepth(const Ray& ray, Interval range) const {
  const LocalRay local = toLocal(ray);
  const auto clipped = clip(local, range);
  if (!clipped) return Rgb(0.f);
  const double d = integral(local, *clipped);
  const Rgb sigma_t = unit_.sigma_t();
  return {static_cast<float>(double{sigma_t.r} * d), static_cast<float>(double{sigma_t.g} * d),
          static_cast<float>(double{sigma_t.b} * d)};
}

std::optional<float> BoxVolume::invertOpticalDepth(const Ray& ray, Interval range, int channel,
                                                   float depth) const {
  if (depth <= 0) return range.t0;
  const double sigma_t = unit_.sigma_t()[channel];
  const LocalRay local = toLocal(ray);
  const auto clipped = clip(local, range);
  if (!clipped || sigma_t == 0) return std::nullopt;
  const auto t = invert(local, *clipped, double{depth} / sigma_t);
  if (!t) return std::nullopt;
  return std::clamp(static_cast<float>(*t), range.t0, range.t1);
}

Rgb BoxVolume::emission(const Ray& ray, Interval range) const {
  if (unit_.Le.isBlack()) return {};
  const LocalRay local = toLocal(ray);
  const auto clipped = clip(local, range);
  if (!clipped) return {};
  const double d = integral(local, *clipped);
  const Rgb sigma_t = unit_.sigma_t();
  Rgb result;
  for (int c = 0; c < 3; ++c)
    result[c] =
        static_cast<float>(double{unit_.Le[c]} * d * exponentialMean(double{sigma_t[c]} * d));
  return result;
}

void BoxVolume::appendPieces(const Ray& ray, Interval range,
                             std::vector<MediumPiece>& pieces) const {
  const LocalRay local = toLocal(ray);
  const auto clipped = clip(local, range);
  if (!clipped) return;
  const std::size_t first = pieces.size();
  appendDensity(local, *clipped, pieces);
  for (std::size_t i = first; i < pieces.size(); ++i) pieces[i].unit = &unit_;
}

}  // namespace brume
