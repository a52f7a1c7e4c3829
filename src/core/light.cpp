// SPDX-License-Identifier: Apache-2.0
#include "core/light.h"

#include "core/sampling.h"

namespace brume {

float lightWeight(const Rgb& c) {
  return Rgb(std::abs(c.r), std::abs(c.g), std::abs(c.b)).luminance();
}

LightBounds pointBounds(const Vec3& position, float weight) {
  LightBounds bounds;
  bounds.box = {position, position};
  bounds.intensity = double{weight};
  return bounds;
}

float boundedInverseSquare(const Vec3& position, const Bounds3& region) {
  // In double: squares of scene lengths from 1e-30 to 1e30 neither vanish nor overflow.
  const Vec3d nearest(max(region.lo, min(region.hi, position)));
  const Vec3d d = Vec3d(position) - nearest, diagonal = Vec3d(region.hi) - Vec3d(region.lo);
  const double squared = std::max(dot(d, d), dot(diagonal, diagonal) / 12);
  constexpr double kMax = 1e30;  // a region of no size around the light itself
  return static_cast<float>(squared > 1 / kMax ? 1 / squared : kMax);
}

float smallestOneMinusCos(const Vec3& position, const Vec3& axis, const Bounds3& region) {
  const Vec3d toCenter = Vec3d(region.center()) - Vec3d(position);
  const double distance = length(toCenter);
  // A little more than the radius, for the rounding of the corners.
  const double radius =
      0.5 * length(Vec3d(region.hi) - Vec3d(region.lo)) * 1.00001 + 1e-6 * distance;
  if (distance <= radius) return 0;
  const double cosine = std::clamp(dot(toCenter, Vec3d(axis)) / distance, -1.0, 1.0);
  const double angle = std::max(0.0, std::acos(cosine) - std::asin(radius / distance));
  return static_cast<float>(2 * sqr(std::sin(0.5 * angle)));
}

std::optional<LightSample> samplePosition(const Vec3& p, const Vec3& lightPosition) {
  const Vec3d d = Vec3d(lightPosition) - Vec3d(p);
  const double squared = dot(d, d), distance = std::sqrt(squared), inverseDistance = 1 / distance;
  const float inverse = static_cast<float>(inverseDistance * inverseDistance);
  if (!std::isfinite(inverse)) return std::nullopt;
  LightSample sample;
  sample.L = Rgb(inverse);
  sample.wi = Vec3(d * inverseDistance);
  sample.pdf = 1;
  sample.distance = static_cast<float>(distance);
  sample.p = lightPosition;
  return sample;
}

float oneMinusCosTheta(const Vec3& w) {
  const double x = w.x, y = w.y, z = w.z, l2 = x * x + y * y + z * z, l = std::sqrt(l2);
  return static_cast<float>(z > 0 ? (x * x + y * y) / (l2 + z * l) : 1 - z / l);
}

float oneMinusCosSeen(const Vec3& p, const Ball& ball) {
  const Vec3d d = Vec3d(ball.center) - Vec3d(p);
  // A little wider than the ball, for the rounding of directions.
  const double radius = double{ball.radius} * 1.0001, sin2 = radius * radius / dot(d, d);
  return sin2 < 1 ? static_cast<float>(sin2 / (1 + std::sqrt(1 - sin2))) : 2.f;
}

AimedDirection aimAt(const Ball& ball, const Vec3& from, Vec2 u) {
  const float omc = oneMinusCosSeen(from, ball);
  if (omc >= 2.f) return {sampleUniformSphere(u), kInv4Pi};
  const Frame frame = Frame::fromZ(Vec3(normalize(Vec3d(ball.center) - Vec3d(from))));
  return {frame.fromLocal(sampleUniformCone(u, omc)), coneUniformPdf(omc)};
}

Vec3 startOfParallelRay(const Ball& target, const Ball& scene, const Vec3& d, Vec2 u) {
  const Frame frame = Frame::fromZ(d);
  const Vec2 p = target.radius * sampleConcentricDisk(u);
  const float back = distance(target.center, scene.center) + scene.radius + target.radius;
  return target.center + frame.x * p.x + frame.y * p.y - d * back;
}

Transform lightFrame(const Vec3& from, const Vec3& to, const SourceLocation& where) {
  const Vec3d d = Vec3d(to) - Vec3d(from);
  const double distance = length(d);
  if (!(distance > 0) || !std::isfinite(distance))
    throw SceneError(where, "\"from\" and \"to\" are the same point: the light has no direction");
  const Vec3d z = d / distance;
  const Vec3d other = std::abs(z.x) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
  const Vec3d x = normalize(cross(other, z));
  Mat4d m(1.0);
  m[0] = glm::dvec4(x, 0);
  m[1] = glm::dvec4(cross(z, x), 0);
  m[2] = glm::dvec4(z, 0);
  m[3] = glm::dvec4(Vec3d(from), 1);
  return Transform(m);
}

}  // namespace brume
