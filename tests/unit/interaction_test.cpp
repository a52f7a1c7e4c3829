// SPDX-License-Identifier: Apache-2.0
#include "core/interaction.h"

#include <gtest/gtest.h>

#include "core/rng.h"
#include "core/sampling.h"

namespace brume {
namespace {

TEST(Interaction, OffsetOriginsLeaveTheErrorBox) {
  Rng rng(1);
  for (const float scale : {1e-6f, 1.f, 1e6f})
    for (int i = 0; i < 1000; ++i) {
      const Vec3 p = (Vec3(rng.uniform(), rng.uniform(), rng.uniform()) - 0.5f) * scale;
      const Vec3 error = abs(p) * (4 * kMachineEpsilon);
      const Vec3 n = sampleUniformSphere(rng.uniform2()), w = sampleUniformSphere(rng.uniform2());
      const Vec3 o = offsetRayOrigin(p, error, n, w);
      // On the side of w, beyond the box's corner that reaches furthest along n.
      const double side = dot(n, w) < 0 ? -1 : 1;
      const double reach = dot(Vec3d(abs(n)), Vec3d(error));
      EXPECT_GE(side * dot(Vec3d(o) - Vec3d(p), Vec3d(n)), reach * (1 - 1e-6));
      EXPECT_LT(length(Vec3d(o) - Vec3d(p)), reach + 1e-6 * length(p));
    }
  EXPECT_EQ(offsetRayOrigin({1, 2, 3}, Vec3(0), {0, 0, 1}, {0, 0, 1}), Vec3(1, 2, 3));
  EXPECT_EQ(offsetRayOrigin({1, 2, 3}, {1, 1, 1}, Vec3(0), {0, 0, 1}), Vec3(1, 2, 3));
  EXPECT_GT(offsetRayOrigin(Vec3(0), Vec3(1e-42f), {0, 0, 1}, {0, 0, 1}).z, 0);
}

/// On a plane p = u a + v b every ray finds its uv exactly; the footprint is their difference.
TEST(Interaction, FootprintsAreDifferencesOfUv) {
  Rng rng(2);
  for (int i = 0; i < 200; ++i) {
    const Vec3 a = sampleUniformSphere(rng.uniform2()) * 2.f,
               b = sampleUniformSphere(rng.uniform2());
    if (length(cross(a, b)) < 0.2f) continue;
    SurfaceInteraction si;
    si.n = normalize(cross(a, b));
    si.geometry.dpdu = a;
    si.geometry.dpdv = b;
    si.uv = {0.3f, 0.6f};
    si.p = a * si.uv.x + b * si.uv.y;
    const Vec3 eye = si.p + si.n * 3.f + a;
    const Vec2 dx(0.01f, -0.02f), dy(0.03f, 0.01f);
    const auto to = [&](Vec2 d) {
      return normalize(a * (si.uv.x + d.x) + b * (si.uv.y + d.y) - eye);
    };
    const FootprintRay ray(Ray{eye, to(Vec2(0))}, {eye, eye, to(dx), to(dy)});
    si.computeFootprint(ray, {10, 20, 30});
    EXPECT_EQ(si.texture.uv, si.uv);
    EXPECT_EQ(si.texture.p, si.p + Vec3(10, 20, 30));
    EXPECT_NEAR(si.texture.dudx, dx.x, 1e-4);
    EXPECT_NEAR(si.texture.dvdx, dx.y, 1e-4);
    EXPECT_NEAR(si.texture.dudy, dy.x, 1e-4);
    EXPECT_NEAR(si.texture.dvdy, dy.y, 1e-4);
    EXPECT_LT(length(si.texture.dpdx - (a * dx.x + b * dx.y)), 1e-4f);
    EXPECT_LT(length(si.texture.dpdy - (a * dy.x + b * dy.y)), 1e-4f);
  }
}

TEST(Interaction, DegenerateFootprintsAreZero) {
  SurfaceInteraction si;
  si.geometry.dpdu = {1, 0, 0};
  si.geometry.dpdv = {0, 1, 0};
  const Ray ray{{0, 0, 1}, {0, 0, -1}};
  si.computeFootprint(FootprintRay(ray), Vec3(0));
  EXPECT_EQ(si.texture.dudx, 0);
  // A neighbouring ray parallel to the surface.
  si.computeFootprint(FootprintRay(ray, {ray.o, ray.o, {1, 0, 0}, {0, 1, 0}}), Vec3(0));
  EXPECT_EQ(si.texture.dudx, 0);
  EXPECT_EQ(si.texture.dpdx, Vec3(0));
  // No parametrisation.
  si.geometry = {};
  si.computeFootprint(FootprintRay(ray, {ray.o, ray.o, {.1f, 0, -1}, {0, .1f, -1}}), Vec3(0));
  EXPECT_EQ(si.texture.dudx, 0);
  EXPECT_GT(si.texture.dpdx.x, 0);
}

}  // namespace
}  // namespace brume
