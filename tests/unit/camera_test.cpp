// SPDX-License-Identifier: Apache-2.0
#include "core/camera.h"

#include <gmock/gmock.h>

#include "support/make_plugin.h"

namespace brume {
namespace {

using namespace test;

std::unique_ptr<Camera> makeCamera(const char* name, std::vector<Param> params,
                                   Vec2i resolution = {400, 200},
                                   const AnimatedTransform& cameraToWorld = {}) {
  Camera::FactoryContext context;
  context.cameraToWorld = cameraToWorld;
  context.resolution = resolution;
  return make<Camera>(name, std::move(params), context);
}

CameraSample at(float x, float y, Vec2 lens = Vec2(0.5f), float time = 0) {
  return {{x, y}, lens, time};
}

void expectNear(const Vec3& a, const Vec3& b, float tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

/// Rounding of a handful of float operations on unit vectors.
constexpr float kRounding = 4e-7f;

TEST(Camera, PerspectiveFovSpansTheShorterAxis) {
  const float t = std::tan(radians(20));
  const auto wide = makeCamera("perspective", {floats("fov", {40})});
  expectNear(wide->generateRay(at(200, 100)).d, {0, 0, 1}, kRounding);
  expectNear(wide->generateRay(at(0, 0)).d, normalize(Vec3(-2 * t, t, 1)), kRounding);
  expectNear(wide->generateRay(at(400, 200)).d, normalize(Vec3(2 * t, -t, 1)), kRounding);
  const auto tall = makeCamera("perspective", {floats("halffov", {20})}, {100, 300});
  expectNear(tall->generateRay(at(0, 0)).d, normalize(Vec3(-t, 3 * t, 1)), kRounding);
  EXPECT_EQ(tall->generateRay(at(0, 0)).o, Vec3(0));
}

TEST(Camera, ScreenWindowAndFrameAspectRatio) {
  const auto window = makeCamera("perspective", {floats("screenwindow", {-1, 0, 0.5f, 2})});
  expectNear(window->generateRay(at(0, 0)).d, normalize(Vec3(-1, 2, 1)), kRounding);
  expectNear(window->generateRay(at(400, 200)).d, normalize(Vec3(0, 0.5f, 1)), kRounding);
  const auto square = makeCamera("perspective", {floats("frameaspectratio", {1})});
  expectNear(square->generateRay(at(0, 0)).d, normalize(Vec3(-1, 1, 1)), kRounding);
  EXPECT_THROW(makeCamera("perspective", {floats("screenwindow", {1, 1, 0, 1})}), SceneError);
}

TEST(Camera, OrthographicRaysAreParallel) {
  const auto camera = makeCamera("orthographic", {floats("screenwindow", {-8, 8, -4, 4})});
  const Ray corner = camera->generateRay(at(0, 0)), middle = camera->generateRay(at(200, 100));
  expectNear(corner.o, {-8, 4, 0}, 1e-5f);
  expectNear(middle.o, {0, 0, 0}, 1e-5f);
  EXPECT_EQ(corner.d, Vec3(0, 0, 1));
  EXPECT_EQ(middle.d, Vec3(0, 0, 1));
}

TEST(Camera, EnvironmentSeesAllAroundWithYUp) {
  const auto camera = makeCamera("environment", {});
  expectNear(camera->generateRay(at(37, 0)).d, {0, 1, 0}, kRounding);
  expectNear(camera->generateRay(at(37, 200)).d, {0, -1, 0}, kRounding);
  expectNear(camera->generateRay(at(0, 100)).d, {1, 0, 0}, kRounding);
  expectNear(camera->generateRay(at(100, 100)).d, {0, 0, 1}, kRounding);
  expectNear(camera->generateRay(at(200, 100)).d, {-1, 0, 0}, kRounding);
}

TEST(Camera, RaysThroughTheLensMeetInFocus) {
  for (const char* name : {"perspective", "orthographic"}) {
    const auto camera =
        makeCamera(name, {floats("lensradius", {0.3f}), floats("focaldistance", {5})});
    for (const Vec2& raster : {Vec2(0, 0), Vec2(333, 20), Vec2(200, 100)}) {
      Vec3 focus;
      for (int i = 0; i < 16; ++i) {
        const Vec2 lens(static_cast<float>(i % 4) / 3.01f, static_cast<float>(i / 4) / 3.01f);
        const Ray ray = camera->generateRay({raster, lens, 0});
        EXPECT_NEAR(length(ray.d), 1, kRounding);
        EXPECT_NEAR(ray.o.z, 0, 1e-6);
        const Vec3 p = ray((5 - ray.o.z) / ray.d.z);
        if (i == 0) focus = p;
        expectNear(p, focus, 1e-5f);  // lengths up to 12
      }
      const auto pinhole = makeCamera(name, {});
      const Ray axis = pinhole->generateRay({raster, Vec2(0.5f), 0});
      expectNear(axis((5 - axis.o.z) / axis.d.z), focus, 1e-5f);
    }
  }
}

TEST(Camera, DifferentialsAreTheRaysOfTheNextPixel) {
  const AnimatedTransform moved(Transform::translate({1, 2, 3}) * Transform::rotate(40, {1, 2, 3}) *
                                Transform::scale(-1, 1, 1));
  for (const char* name : {"perspective", "orthographic", "environment"})
    for (float radius : {0.f, 0.2f}) {
      const auto camera = makeCamera(
          name, {floats("lensradius", {radius}), floats("focaldistance", {3})}, {40, 30}, moved);
      for (const Vec2& p : {Vec2(0, 0), Vec2(20.5f, 3.25f), Vec2(38, 28)}) {
        const Vec2 lens(0.9f, 0.3f);
        const FootprintRay ray = camera->generateRay({p, lens, 0});
        const Ray x = camera->generateRay({p + Vec2(1, 0), lens, 0});
        const Ray y = camera->generateRay({p + Vec2(0, 1), lens, 0});
        ASSERT_TRUE(ray.differential);
        expectNear(ray.differential->rxOrigin, x.o, 2e-6f);
        expectNear(ray.differential->ryOrigin, y.o, 2e-6f);
        expectNear(ray.differential->rxDirection, x.d, 2e-6f);
        expectNear(ray.differential->ryDirection, y.d, 2e-6f);
      }
    }
}

TEST(Camera, DirectionsAreUnitUnderAScaleWhichWarns) {
  const int before = captureLog().warningCount();
  const AnimatedTransform scaled(Transform::scale(1e-3, 2, 1e3));
  for (const char* name : {"perspective", "orthographic", "environment"}) {
    const auto camera = makeCamera(name, {}, {40, 30}, scaled);
    const FootprintRay ray = camera->generateRay(at(3, 7));
    EXPECT_NEAR(length(ray.d), 1, kRounding) << name;
    EXPECT_NEAR(length(ray.differential->rxDirection), 1, kRounding) << name;
  }
  EXPECT_EQ(captureLog().warningCount(), before + 3);
  makeCamera("perspective", {}, {4, 3}, AnimatedTransform(Transform::scale(-1, 1, 1)));
  EXPECT_EQ(captureLog().warningCount(), before + 3);  // a mirror is no scale
}

TEST(Camera, MovesWhileTheShutterIsOpen) {
  const AnimatedTransform motion(Transform(), 0, Transform::translate({8, 0, 0}), 4);
  const auto camera = makeCamera(
      "perspective", {floats("shutteropen", {1}), floats("shutterclose", {3})}, {40, 30}, motion);
  for (float u : {0.f, 0.25f, 0.75f}) {
    const Ray ray = camera->generateRay(at(20, 15, Vec2(0.5f), u));
    EXPECT_FLOAT_EQ(ray.time, 1 + 2 * u);
    expectNear(ray.o, {2 * ray.time, 0, 0}, 1e-5f);
  }
  const int before = captureLog().warningCount();
  const auto swapped =
      makeCamera("perspective", {floats("shutteropen", {3}), floats("shutterclose", {1})});
  EXPECT_EQ(captureLog().warningCount(), before + 1);
  EXPECT_FLOAT_EQ(swapped->generateRay(at(0, 0)).time, 1);
}

TEST(Camera, EndsOfTheRanges) {
  for (float fov : {1e-3f, 179.99f}) {
    const auto camera = makeCamera(
        "perspective",
        {floats("fov", {fov}), floats("lensradius", {1e6f}), floats("focaldistance", {1e-6f})});
    EXPECT_TRUE(isFinite(camera->generateRay(at(0, 0, {0.1f, 0.9f})).d)) << fov;
  }
  const auto far = makeCamera("perspective", {floats("lensradius", {0.1f})});  // focus at 1e30
  EXPECT_NEAR(length(far->generateRay(at(0, 0, {0.1f, 0.9f})).d), 1, kRounding);
  for (const char* name : {"fov", "halffov", "focaldistance", "frameaspectratio"})
    EXPECT_THROW(makeCamera("perspective", {floats(name, {0})}), SceneError) << name;
  EXPECT_THROW(makeCamera("perspective", {floats("fov", {180})}), SceneError);
  EXPECT_THROW(makeCamera("perspective", {floats("lensradius", {-1})}), SceneError);
  EXPECT_NO_THROW(makeCamera("orthographic", {floats("lensradius", {1e6f})}, {1, 1}));
  EXPECT_NO_THROW(makeCamera("environment", {}, {1, 1}));
}

}  // namespace
}  // namespace brume
