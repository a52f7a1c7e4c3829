// SPDX-License-Identifier: Apache-2.0
#include "core/shape.h"

namespace brume {

std::optional<ShapeHit> Shape::intersect(const Ray&) const { return std::nullopt; }

std::optional<ShapeSample> Shape::sampleSolidAngle(const Vec3& ref, Vec2 u) const {
  ShapeSample sample = sampleArea(u);
  const Vec3d toLight = Vec3d(sample.p) - Vec3d(ref);
  const double distance2 = dot(toLight, toLight);
  const double cosine = std::abs(dot(toLight, Vec3d(sample.n))) / std::sqrt(distance2);
  const double pdf = sample.pdf * distance2 / cosine;
  sample.pdf = static_cast<float>(pdf);
  // Not so for a point on the shape itself, a grazing direction, a degenerate shape.
  if (!(sample.pdf > 0.f) || !std::isfinite(sample.pdf)) return std::nullopt;
  return sample;
}

float Shape::pdfSolidAngle(const Vec3& ref, const Vec3& wi, const Vec3& hitPoint,
                           const Vec3& hitNormal) const {
  const Vec3d toLight = Vec3d(hitPoint) - Vec3d(ref);
  const double cosine = std::abs(dot(Vec3d(wi), Vec3d(hitNormal)));
  const double pdf = pdfArea(hitPoint, hitNormal) * dot(toLight, toLight) / cosine;
  return std::isfinite(pdf) ? static_cast<float>(pdf) : 0.f;
}

float Shape::pdfArea(const Vec3&, const Vec3&) const { return 1.f / area(); }

}  // namespace brume
