// SPDX-License-Identifier: Apache-2.0
// Quadrics with their parametric form written down a second time, and transforms to try them under.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/rng.h"
#include "core/shape.h"
#include "support/make_plugin.h"

namespace brume::test {

inline constexpr double kPiD = 3.14159265358979323846;

struct QuadricCase {
  std::string label, plugin;
  std::vector<Param> params;
  std::function<Vec3d(double, double)> at;       ///< object-space point of (u, v) in [0, 1]^2
  std::function<double(const Vec3d&)> implicit;  ///< zero on the surface, object space
  double area = 0;                               ///< object space, closed form
};

inline Vec3d turned(double phi, double r, double z) {
  return {r * std::cos(phi), r * std::sin(phi), z};
}

inline std::vector<QuadricCase> quadricCases() {
  const auto round = [](double q0, double q1, double q2) {
    return [=](const Vec3d& p) { return p.x * p.x + p.y * p.y - (q0 + p.z * (q1 + p.z * q2)); };
  };
  std::vector<QuadricCase> cases;
  cases.push_back({"sphere",
                   "sphere",
                   {floats("radius", {2})},
                   [](double u, double v) {
                     const double theta = kPiD * (1 - v);
                     return turned(2 * kPiD * u, 2 * std::sin(theta), 2 * std::cos(theta));
                   },
                   round(4, 0, -1),
                   16 * kPiD});
  cases.push_back({"part of a sphere",
                   "sphere",
                   {floats("radius", {2}), floats("zmin", {-1}), floats("zmax", {1.5f}),
                    floats("phimax", {200})},
                   [](double u, double v) {
                     const double a = std::acos(-0.5), b = std::acos(0.75), theta = a + v * (b - a);
                     return turned(200 / 180. * kPiD * u, 2 * std::sin(theta), 2 * std::cos(theta));
                   },
                   round(4, 0, -1),
                   200 / 180. * kPiD * 2 * 2.5});
  cases.push_back({"disk",
                   "disk",
                   {floats("radius", {3}), floats("height", {0.5f})},
                   [](double u, double v) { return turned(2 * kPiD * u, 3 * (1 - v), 0.5); },
                   [](const Vec3d& p) { return p.z - 0.5; },
                   9 * kPiD});
  cases.push_back({"part of a ring",
                   "disk",
                   {floats("radius", {3}), floats("innerradius", {1}), floats("phimax", {90})},
                   [](double u, double v) { return turned(0.5 * kPiD * u, 3 - 2 * v, 0); },
                   [](const Vec3d& p) { return p.z; },
                   2 * kPiD});
  cases.push_back({"cylinder",
                   "cylinder",
                   {floats("radius", {1.5f}), floats("zmin", {-1}), floats("zmax", {3}),
                    floats("phimax", {300})},
                   [](double u, double v) { return turned(5 / 3. * kPiD * u, 1.5, -1 + 4 * v); },
                   round(2.25, 0, 0),
                   5 / 3. * kPiD * 1.5 * 4});
  cases.push_back({"cone",
                   "cone",
                   {floats("radius", {1.5f}), floats("height", {2})},
                   [](double u, double v) { return turned(2 * kPiD * u, 1.5 * (1 - v), 2 * v); },
                   round(2.25, -2.25, 0.5625),
                   kPiD * 1.5 * 2.5});
  cases.push_back({"paraboloid",
                   "paraboloid",
                   {floats("radius", {2}), floats("zmin", {0.25f}), floats("zmax", {1})},
                   [](double u, double v) {
                     const double z = 0.25 + 0.75 * v;
                     return turned(2 * kPiD * u, 2 * std::sqrt(z), z);
                   },
                   round(0, 4, 0),
                   2 * kPiD / 6 * (std::pow(8, 1.5) - std::pow(5, 1.5))});
  // The segment (1,-1,-1) to (1,2,1): its waist is not at z = 0. Area by Simpson's rule below.
  const auto segment = [](double u, double v) {
    const double phi = 2 * kPiD * u, y = -1 + 3 * v;
    return Vec3d(std::cos(phi) - y * std::sin(phi), std::sin(phi) + y * std::cos(phi), -1 + 2 * v);
  };
  double area = 0;
  for (int i = 0; i <= 2000; ++i) {
    // r^2 dz^2 + (y dy)^2 with r^2 = 1 + y^2, dz = 2, dy = 3.
    const double y = -1 + 3 * i / 2000., element = std::sqrt(4 * (1 + y * y) + 9 * y * y);
    area += element * (i == 0 || i == 2000 ? 1 : i % 2 ? 4 : 2) / 6000 * 2 * kPiD;
  }
  // y = -1 + 3 (z + 1) / 2 = 0.5 + 1.5 z.
  cases.push_back({"hyperboloid",
                   "hyperboloid",
                   {points("p1", {{1, -1, -1}}), points("p2", {{1, 2, 1}})},
                   segment,
                   round(1.25, 1.5, 2.25),
                   area});
  cases.push_back(
      {"hyperboloid with defaults, a cone",
       "hyperboloid",
       {},
       [](double u, double v) { return turned(2 * kPiD * u + kPiD / 4, std::sqrt(2) * v, v); },
       round(0, 0, 2),
       kPiD * std::sqrt(2) * std::sqrt(3)});
  return cases;
}

struct TransformCase {
  std::string label;
  Transform transform;
  double similarity = 0;  ///< scale of lengths, 0 when it differs with the direction
};

inline std::vector<TransformCase> transformCases() {
  const Transform turn = Transform::rotate(37, {1, 2, -0.5});
  return {{"identity", Transform(), 1},
          {"moved and turned", Transform::translate({3, -2, 7}) * turn, 1},
          {"mirrored", turn * Transform::scale(-2, 2, 2), 2},
          {"tiny", Transform::scale(1e-6, 1e-6, 1e-6) * turn, 1e-6},
          {"huge", turn * Transform::scale(1e6, 1e6, 1e6), 1e6},
          {"far away", Transform::translate({1e5, 1e5, -1e5}) * turn, 1},
          {"stretched", turn * Transform::scale(1, 3, 0.5) * turn, 0}};
}

inline std::unique_ptr<Shape> makeShape(std::string_view plugin, std::vector<Param> params,
                                        const Transform& transform = {}, bool reverse = false) {
  Shape::FactoryContext context;
  context.objectToShape = transform;
  context.reverseOrientation = reverse;
  return make<Shape>(plugin, std::move(params), context);
}

inline Vec3d apply(const Transform& t, const Vec3d& p) {
  return Vec3d(t.matrix() * glm::dvec4(p, 1));
}

inline Vec3 randomPoint(Rng& rng, const Bounds3& b, float scale) {
  const Vec3 u(rng.uniform(), rng.uniform(), rng.uniform());
  return b.center() + (u - 0.5f) * (scale * length(b.diagonal()));
}

}  // namespace brume::test
