// SPDX-License-Identifier: Apache-2.0
// The footprint of specular rays against rays that are really traced beside them.
#include "transport/specular.h"

#include <gtest/gtest.h>

#include "core/log.h"
#include "core/material.h"
#include "support/render_text.h"

namespace brume {
namespace {

struct Bounce {
  FootprintRay ray;
  bool isTransmission = false;
};

/// Follows a chain of specular bounces, refraction where `transmit` is set.
Bounce follow(const Scene& scene, FootprintRay ray, const std::vector<bool>& transmit) {
  Stats stats;
  Bounce bounce{ray, false};
  for (const bool t : transmit) {
    const auto hit = scene.intersect(bounce.ray, stats);
    EXPECT_TRUE(hit.has_value());
    if (!hit) return bounce;
    Bsdf bsdf;
    hit->material->evaluate(*hit, bsdf);
    const LobeFlags lobes = (t ? kTransmission : kReflection) | kSpecular;
    const auto sample = bsdf.sample(hit->wo, 0.5f, Vec2(0.5f), lobes);
    EXPECT_TRUE(sample.has_value());
    if (!sample) return bounce;
    bounce = {specularRay(bounce.ray, *hit, bsdf.shadingNormal(), *sample),
              sample->isTransmission()};
  }
  return bounce;
}

/// Largest deviation of the carried neighbour's direction from that of the neighbour really traced,
/// relative to the distance between neighbours.
double directionError(const std::string& world, const std::vector<bool>& transmit, float step) {
  Log::Options options;
  options.capture = true;
  Log log(options);
  const auto job = makeJob("WorldBegin\n" + world + "\nWorldEnd\n", {}, log);
  const Scene& scene = job->scene();
  Ray centre;
  centre.o = Vec3(0, 0, -4);
  centre.d = normalize(Vec3(.1f, .07f, 1));
  Ray x = centre, y = centre;
  x.d = normalize(centre.d + Vec3(step, 0, 0));
  y.d = normalize(centre.d + Vec3(0, step, 0));
  const FootprintRay in(centre, RayDifferential{x.o, y.o, x.d, y.d});
  const Bounce out = follow(scene, in, transmit);
  const Bounce outX = follow(scene, FootprintRay(x), transmit);
  const Bounce outY = follow(scene, FootprintRay(y), transmit);
  EXPECT_TRUE(out.ray.differential.has_value());
  if (!out.ray.differential) return 1;
  const RayDifferential& rd = *out.ray.differential;
  const double ex =
      distance(normalize(rd.rxDirection), outX.ray.d) / distance(out.ray.d, outX.ray.d);
  const double ey =
      distance(normalize(rd.ryDirection), outY.ray.d) / distance(out.ray.d, outY.ray.d);
  return std::max(ex, ey);
}

// A step of 1e-3: the second-order term of the bounce is of the order of a few steps, float
// rounding of the directions 1e-7 / 1e-3.
constexpr float kStep = 1e-3f;
constexpr double kTolerance = 0.02;

TEST(SpecularRay, PlaneMirror) {
  EXPECT_LT(directionError("Material \"mirror\" Rotate 20 1 1 0 Shape \"trianglemesh\" \"integer "
                           "indices\" [0 1 2] \"point P\" [-9 -9 0  9 -9 0  0 9 0]",
                           {false}, kStep),
            kTolerance);
}

TEST(SpecularRay, SphereMirror) {
  EXPECT_LT(directionError("Material \"mirror\" Shape \"sphere\"", {false}, kStep), kTolerance);
}

TEST(SpecularRay, GlassSphereEnterAndLeave) {
  const std::string glass = "Material \"glass\" \"float index\" [1.5] Shape \"sphere\"";
  EXPECT_LT(directionError(glass, {true}, kStep), kTolerance);
  EXPECT_LT(directionError(glass, {true, true}, kStep), 2 * kTolerance);
  EXPECT_LT(directionError(glass, {true, false, true}, kStep), 3 * kTolerance);
}

TEST(SpecularRay, GlassSphereWithTurnedNormals) {
  const std::string glass =
      "ReverseOrientation Material \"glass\" \"float index\" [1.5] Shape \"sphere\"";
  EXPECT_LT(directionError(glass, {true}, kStep), kTolerance);
}

TEST(SpecularRay, WithoutFootprintNoneIsMade) {
  Log::Options options;
  options.capture = true;
  Log log(options);
  const auto job = makeJob("WorldBegin Material \"mirror\" Shape \"sphere\"\nWorldEnd\n", {}, log);
  Ray centre;
  centre.o = Vec3(0, 0, -4);
  EXPECT_FALSE(follow(job->scene(), FootprintRay(centre), {false}).ray.differential.has_value());
}

}  // namespace
}  // namespace brume
