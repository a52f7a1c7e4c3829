// SPDX-License-Identifier: Apache-2.0
#include "core/light.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include "core/light_map.h"
#include "core/rng.h"
#include "support/make_plugin.h"

namespace brume {
namespace {

/// Files of this process alone: tests run side by side.
std::string ownTempDir() {
  return testing::TempDir() + "brume_light_" + std::to_string(::getpid()) + "_";
}

using namespace test;
using testing::HasSubstr;

std::unique_ptr<Light> makeLight(const char* name, std::vector<Param> params,
                                 const Transform& lightToWorld = {}) {
  Light::FactoryContext context;
  context.lightToWorld = lightToWorld;
  return make<Light>(name, std::move(params), context);
}

/// Writes a map of random values, dark in the first column and bright in one pixel.
std::string writeMap(const char* name, int width, int height) {
  LayeredImage image;
  image.displaySize = {width, height};
  image.dataWindow = {{0, 0}, {width, height}};
  Rng rng(5);
  for (const char* c : {"R", "G", "B"}) {
    std::vector<float>& values = image.channels[c];
    for (int i = 0; i < width * height; ++i)
      values.push_back(i % width == 0 ? 0.f : rng.uniform() + (i == width + 2 ? 20.f : 0.f));
  }
  std::string path = ownTempDir() + name;
  writeImage(path, image, PixelPrecision::Float);
  return path;
}

/// Integral of the irradiance over a sphere around the light, by the midpoint rule: the power that
/// passes through it.
Rgb powerThroughSphere(const Light& light, float radius) {
  constexpr int kZ = 512, kPhi = 256;
  double sum[3] = {0, 0, 0};
  for (int i = 0; i < kZ; ++i)
    for (int j = 0; j < kPhi; ++j) {
      const double z = -1 + (i + 0.5) * 2 / kZ, phi = (j + 0.5) * 2 * M_PI / kPhi;
      const double r = std::sqrt(1 - z * z);
      const Vec3 w(Vec3d(r * std::cos(phi), r * std::sin(phi), z));
      const auto sample = light.sampleLi(*light.position() + radius * w, Vec2(0.5f));
      if (!sample) continue;
      for (int c = 0; c < 3; ++c)
        sum[c] += static_cast<double>(sample->L[c] * radius * radius) * 4 * M_PI / (kZ * kPhi);
    }
  return {static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
}

void expectRelative(const Rgb& a, const Rgb& b, float tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance * std::abs(b[c])) << c;
}

TEST(Light, PointFallsOffWithDistanceSquared) {
  // The transform comes first, then `from` in world space.
  const auto light = makeLight(
      "point",
      {color("I", {10, 20, 30}), color("scale", {2, 1, 0.5f}), points("from", {{1, 0, 0}})},
      Transform::translate({0, 0, 5}) * Transform::scale(3, 3, 3));
  EXPECT_EQ(*light->position(), Vec3(1, 0, 5));
  const auto sample = light->sampleLi({1, 0, 1}, Vec2(0));
  ASSERT_TRUE(sample);
  expectRelative(sample->L, Rgb(20, 20, 15) / 16, 1e-6f);
  EXPECT_EQ(sample->wi, Vec3(0, 0, 1));
  EXPECT_EQ(sample->pdf, 1);
  EXPECT_FLOAT_EQ(sample->distance, 4);
  EXPECT_FALSE(light->sampleLi({1, 0, 5}, Vec2(0)));  // at the light itself
  expectRelative(powerThroughSphere(*light, 1e-4f), light->power(), 1e-3f);
  expectRelative(powerThroughSphere(*light, 1e4f), light->power(), 1e-5f);
}

TEST(Light, PointIsExactFarFromTheOrigin) {
  // Render space is the world moved by the camera's position: the sum is taken in double.
  const auto light = makeLight("point", {points("from", {{100000, 100000, 100000}})},
                               Transform::translate({-99999.75, -100000.125, -100000.0}));
  EXPECT_EQ(*light->position(), Vec3(0.25f, -0.125f, 0));
}

TEST(Light, SpotHasThePowerOfItsFalloff) {
  const auto light = makeLight(
      "spot", {color("I", Rgb(7)), points("from", {{1, 2, 3}}), points("to", {{1, 2, -5}}),
               floats("coneangle", {40}), floats("conedeltaangle", {15})});
  const auto along = [&](float degrees) {
    const float a = radians(degrees);
    const auto s =
        light->sampleLi(Vec3(1, 2, 3) + 2.f * Vec3(std::sin(a), 0, -std::cos(a)), Vec2(0));
    return s ? s->L.g * 4 / 7 : 0.f;
  };
  EXPECT_FLOAT_EQ(along(0), 1);
  EXPECT_FLOAT_EQ(along(24.9f), 1);
  const float d = (std::cos(radians(30)) - std::cos(radians(40))) /
                  (std::cos(radians(25)) - std::cos(radians(40)));
  EXPECT_NEAR(along(30), d * d * d * d, 1e-5);
  EXPECT_EQ(along(40.1f), 0);
  EXPECT_EQ(along(180), 0);
  // Midpoint rule over a function with a kink.
  expectRelative(powerThroughSphere(*light, 2), light->power(), 2e-3f);
}

TEST(Light, SpotKeepsItsShapeWhenNarrowAndWhenWide) {
  for (float angle : {0.01f, 1.f, 90.f, 180.f}) {
    const auto light =
        makeLight("spot", {floats("coneangle", {angle}), floats("conedeltaangle", {angle / 2})});
    const float a = radians(0.75f * angle);
    const auto s = light->sampleLi({std::sin(a), 0, std::cos(a)}, Vec2(0));
    ASSERT_TRUE(s) << angle;
    const double omc = 2 * sqr(std::sin(0.375 * angle * M_PI / 180)),
                 edge = 2 * sqr(std::sin(0.5 * angle * M_PI / 180)),
                 start = 2 * sqr(std::sin(0.25 * angle * M_PI / 180));
    EXPECT_NEAR(s->L.r, std::pow((edge - omc) / (edge - start), 4), 1e-4) << angle;
  }
  const int before = captureLog().warningCount();
  makeLight("spot", {floats("coneangle", {10}), floats("conedeltaangle", {12})});
  EXPECT_EQ(captureLog().warningCount(), before + 1);
  EXPECT_THROW(makeLight("spot", {floats("coneangle", {10}), floats("conedeltaangle", {21})}),
               SceneError);
  EXPECT_THROW(makeLight("spot", {floats("coneangle", {0})}), SceneError);
  EXPECT_THROW(makeLight("spot", {floats("coneangle", {180.1f})}), SceneError);
  EXPECT_THROW(makeLight("spot", {points("to", {{0, 0, 0}})}), SceneError);
}

TEST(Light, DistantIsTheSameEverywhere) {
  const auto light = makeLight(
      "distant", {color("L", {1, 2, 3}), points("from", {{0, 4, 0}}), points("to", {{0, 0, 0}})},
      Transform::rotate(90, {1, 0, 0}) * Transform::scale(5, 5, 5));
  const auto sample = light->sampleLi({1e6f, 3, 2}, Vec2(0.3f));
  ASSERT_TRUE(sample);
  EXPECT_NEAR(distance(sample->wi, Vec3(0, 0, 1)), 0, 1e-6);
  EXPECT_EQ(sample->L, Rgb(1, 2, 3));
  EXPECT_TRUE(std::isinf(sample->distance));
  EXPECT_TRUE(light->isDelta());
  EXPECT_FALSE(light->position());
  light->setSceneBounds({Vec3(-1), Vec3(1)});
  expectRelative(light->power(), Rgb(1, 2, 3) * (3 * kPi), 1e-6f);
  EXPECT_THROW(makeLight("distant", {points("to", {{0, 0, 0}})}), SceneError);
}

TEST(Light, GoniometricMapHasItsPoleAlongY) {
  // Rows of an EXR from the pole down: 1, 2, 3, 4.
  LayeredImage image;
  image.displaySize = {1, 4};
  image.dataWindow = {{0, 0}, {1, 4}};
  for (const char* c : {"R", "G", "B"}) image.channels[c] = {1, 2, 3, 4};
  for (const char* name : {"rows.exr", "rows.pfm"}) {
    const std::string path = ownTempDir() + name;
    writeImage(path, image, PixelPrecision::Float);
    const auto light = makeLight("goniometric", {string("mapname", path), color("I", Rgb(2))});
    const bool isExr = std::string(name) == "rows.exr";
    EXPECT_FLOAT_EQ(light->sampleLi({0, 1, 0}, Vec2(0))->L.r, isExr ? 2 : 8);
    EXPECT_FLOAT_EQ(light->sampleLi({0, -1, 0}, Vec2(0))->L.r, isExr ? 8 : 2);
    EXPECT_FLOAT_EQ(light->sampleLi({0, 0, 1}, Vec2(0))->L.r, 5);
    expectRelative(powerThroughSphere(*light, 3), light->power(), 2e-3f);
  }
  const auto rotated = makeLight("goniometric", {string("mapname", writeMap("gonio.exr", 16, 8))},
                                 Transform::rotate(70, {1, 1, 0}));
  expectRelative(powerThroughSphere(*rotated, 1), rotated->power(), 0.01f);  // bilinear kinks
}

TEST(Light, ProjectionFillsItsWindow) {
  const auto light = makeLight("projection", {floats("fov", {60}), color("I", Rgb(3))});
  const float t = std::tan(radians(30));
  const auto at = [&](float x, float y) {
    const auto s = light->sampleLi({x * t, y * t, 1}, Vec2(0));
    return s ? s->L.r * (1 + sqr(x * t) + sqr(y * t)) : 0.f;
  };
  EXPECT_NEAR(at(0.99f, -0.99f), 3, 1e-5);
  EXPECT_EQ(at(1.01f, 0), 0);
  EXPECT_EQ(at(0, -1.01f), 0);
  EXPECT_FALSE(light->sampleLi({0, 0, -1}, Vec2(0)));
  // Solid angle of a square pyramid: 4 asin(sin^2(fov/2)).
  const float solidAngle = 4 * std::asin(sqr(std::sin(radians(30))));
  expectRelative(light->power(), Rgb(3 * solidAngle), 1e-4f);

  const auto image = makeLight("projection", {string("mapname", writeMap("slide.exr", 12, 6))},
                               Transform::rotate(30, {0, 1, 0}));
  // The midpoint rule on the sphere misses up to a row of points at the window's border.
  expectRelative(powerThroughSphere(*image, 1), image->power(), 0.02f);
}

TEST(Light, ProjectionPutsTheFirstRowBelow) {
  LayeredImage image;
  image.displaySize = {2, 2};
  image.dataWindow = {{0, 0}, {2, 2}};
  for (const char* c : {"R", "G", "B"}) image.channels[c] = {1, 2, 3, 4};
  const std::string path = ownTempDir() + "slide2.exr";
  writeImage(path, image, PixelPrecision::Float);
  const auto light = makeLight("projection", {string("mapname", path), floats("fov", {90})});
  const auto value = [&](float x, float y) {
    return light->sampleLi({x, y, 1}, Vec2(0))->L.r * (1 + x * x + y * y);
  };
  EXPECT_NEAR(value(-0.6f, -0.6f), 1, 1e-5);
  EXPECT_NEAR(value(0.6f, -0.6f), 2, 1e-5);
  EXPECT_NEAR(value(-0.6f, 0.6f), 3, 1e-5);
  EXPECT_NEAR(value(0, 0), 2.5f, 1e-5);
}

TEST(Light, ConstantInfiniteLight) {
  const auto light = makeLight("infinite", {color("L", {1, 2, 3}), integers("nsamples", {8})});
  EXPECT_EQ(light->sampleCount(), 8);
  EXPECT_TRUE(light->isInfinite());
  const auto sample = light->sampleLi(Vec3(0), {0.2f, 0.7f});
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->L, Rgb(1, 2, 3));
  EXPECT_EQ(sample->pdf, light->pdfLi(Vec3(0), sample->wi));
  light->setSceneBounds({Vec3(-1), Vec3(1)});
  expectRelative(light->power(), Rgb(1, 2, 3) * (12 * kPi * kPi), 1e-6f);
}

TEST(Light, InfiniteLightHasZUpAndXAtTheLeftBorder) {
  LayeredImage image;
  image.displaySize = {4, 2};
  image.dataWindow = {{0, 0}, {4, 2}};
  for (const char* c : {"R", "G", "B"}) image.channels[c] = {0, 0, 0, 0, 1, 2, 3, 4};
  const std::string path = ownTempDir() + "zup.exr";
  writeImage(path, image, PixelPrecision::Float);
  const auto light = makeLight("infinite", {string("mapname", path)});
  const auto towards = [&](float degrees, float z) {
    const float phi = radians(degrees);
    return light->Le(Ray{Vec3(0), normalize(Vec3(std::cos(phi), std::sin(phi), z))}).r;
  };
  EXPECT_EQ(towards(45, 9), 0);           // first row around +z
  EXPECT_NEAR(towards(45, -9), 1, 1e-5);  // centre of the first column
  EXPECT_NEAR(towards(135, -9), 2, 1e-5);
  EXPECT_NEAR(towards(0, -9), 2.5f, 1e-5);  // between the last column and the first
}

/// Directions in a grid of equal solid angle.
int binOf(const Vec3& w) {
  const float phi = std::atan2(w.y, w.x) + kPi;
  const int x = std::min(15, static_cast<int>(phi / (2 * kPi) * 16));
  const int y = std::min(7, static_cast<int>((w.z + 1) * 4));
  return y * 16 + x;
}

TEST(Light, InfiniteLightSamplesWhatItsPdfSays) {
  const std::string path = writeMap("env.exr", 9, 5);
  for (const Transform& transform :
       {Transform(), Transform::rotate(50, {1, 2, 3}) * Transform::scale(-1, 1, 1),
        Transform::scale(3, 1, 0.5) * Transform::rotate(20, {0, 1, 0})}) {
    const auto light = makeLight("infinite", {string("mapname", path)}, transform);
    constexpr int kBins = 128, kSamples = 100000, kSub = 48;
    std::vector<double> expected(kBins), observed(kBins);
    double integral = 0, fluence = 0;
    for (int y = 0; y < 8 * kSub; ++y)
      for (int x = 0; x < 16 * kSub; ++x) {
        const double z = -1 + (y + 0.5) / (4 * kSub), phi = -M_PI + (x + 0.5) * M_PI / (8 * kSub);
        const double r = std::sqrt(1 - z * z);
        const Vec3 w(Vec3d(r * std::cos(phi), r * std::sin(phi), z));
        const double solidAngle = 4 * M_PI / (kBins * kSub * kSub);
        const double pdf = static_cast<double>(light->pdfLi(Vec3(0), w));
        const float L = light->Le(Ray{Vec3(0), w}).g;
        EXPECT_TRUE(pdf > 0 || L == 0);  // nothing bright is missed
        expected[static_cast<std::size_t>(binOf(w))] += pdf * solidAngle;
        integral += pdf * solidAngle;
        fluence += static_cast<double>(L) * solidAngle;
      }
    EXPECT_NEAR(integral, 1, 2e-3);  // midpoint rule across the borders of the map's pixels
    Rng rng(1);
    double estimate = 0;
    for (int i = 0; i < kSamples; ++i) {
      const auto sample = light->sampleLi(Vec3(0), rng.uniform2());
      ASSERT_TRUE(sample);
      observed[static_cast<std::size_t>(binOf(sample->wi))] += 1;
      EXPECT_NEAR(length(sample->wi), 1, 1e-6);
      // A direction on the border of a map pixel may round into the next one.
      if (i % 16 == 0) {
        const float pdf = light->pdfLi(Vec3(0), sample->wi);
        if (std::abs(pdf / sample->pdf - 1) < 1e-2f) {
          EXPECT_NEAR(light->Le(Ray{Vec3(0), sample->wi}).g, sample->L.g,
                      1e-3f * sample->L.g + 1e-3f);
        }
      }
      estimate += static_cast<double>(sample->L.g / sample->pdf) / kSamples;
    }
    EXPECT_NEAR(estimate / fluence, 1, 0.02);  // unbiased; about 5 standard errors
    double chiSquare = 0;
    int degrees = -1;
    for (std::size_t b = 0; b < kBins; ++b) {
      const double n = expected[b] * kSamples / integral;
      if (n < 10) continue;
      chiSquare += sqr(observed[b] - n) / n;
      ++degrees;
    }
    // Mean `degrees`, standard deviation sqrt(2 degrees): beyond 5 of them once in a million.
    EXPECT_LT(chiSquare, degrees + 5 * std::sqrt(2.0 * degrees));
  }
}

TEST(Light, InfiniteLightSurvivesExtremeMaps) {
  LayeredImage image;
  image.displaySize = {4, 4};
  image.dataWindow = {{0, 0}, {4, 4}};
  for (const char* c : {"R", "G", "B"}) image.channels[c].assign(16, 0.f);
  for (float v : {0.f, 1e30f, kInfinity, -1.f, std::numeric_limits<float>::quiet_NaN()}) {
    for (const char* c : {"R", "G", "B"}) image.channels[c][5] = v;
    const std::string path = ownTempDir() + "extreme.exr";
    writeImage(path, image, PixelPrecision::Float);
    const auto light = makeLight("infinite", {string("mapname", path)});
    Rng rng(2);
    for (int i = 0; i < 1000; ++i) {
      const auto sample = light->sampleLi(Vec3(0), rng.uniform2());
      if (!sample) continue;
      EXPECT_TRUE(sample->L.isFinite());
      EXPECT_GT(sample->pdf, 0);
      EXPECT_TRUE(std::isfinite(sample->L.r / sample->pdf));
    }
  }
}

/// A disk of radius 1 around the z axis at height 0, normal +z.
class Disk final : public Shape {
 public:
  explicit Disk(bool canBeSampled = true) : canBeSampled_(canBeSampled) {}
  Bounds3 bounds() const override { return {{-1, -1, 0}, {1, 1, 0}}; }
  float area() const override { return kPi; }
  SurfaceInteraction interaction(const Ray&, const ShapeHit&) const override { return {}; }
  bool canSample() const override { return canBeSampled_; }
  ShapeSample sampleArea(Vec2 u) const override {
    const Vec2 d = sampleConcentricDisk(u);
    ShapeSample s;
    s.p = {d.x, d.y, 0};
    s.pdf = kInvPi;
    return s;
  }
  std::optional<ShapeSample> sampleSolidAngle(const Vec3& ref, Vec2 u) const override {
    ShapeSample s = sampleArea(u);
    s.pdf = pdfSolidAngle(ref, normalize(s.p - ref), s.p, s.n);
    return s;
  }
  float pdfSolidAngle(const Vec3& ref, const Vec3& wi, const Vec3& p,
                      const Vec3& n) const override {
    return lengthSquared(p - ref) / (absDot(n, wi) * kPi);
  }

 private:
  bool canBeSampled_;
};

std::unique_ptr<AreaLight> makeAreaLight(const Shape& shape, std::vector<Param> params) {
  AreaLight::FactoryContext context;
  context.shape = &shape;
  return make<AreaLight>("diffuse", std::move(params), context);
}

TEST(Light, AreaLightShinesFromTheFrontOnly) {
  const Disk disk;
  const auto light = makeAreaLight(disk, {color("L", Rgb(2)), color("scale", Rgb(3))});
  EXPECT_EQ(light->L({0, 0, 0}, {0, 0, 1}, Vec2(0), {0, 0, 1}), Rgb(6));
  EXPECT_EQ(light->L({0, 0, 0}, {0, 0, 1}, Vec2(0), {0, 0, -1}), Rgb());
  EXPECT_FALSE(light->sampleLi({0, 0, -2}, Vec2(0.3f)));
  expectRelative(light->power(), Rgb(6 * kPi * kPi), 1e-6f);
  Rng rng(3);
  double irradiance = 0;
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    const auto s = light->sampleLi({0, 0, 2}, rng.uniform2());
    ASSERT_TRUE(s);
    EXPECT_FLOAT_EQ(s->pdf, light->pdfLiAt({0, 0, 2}, s->wi, s->p, s->n));
    irradiance += static_cast<double>(s->L.r / s->pdf * -s->wi.z) / kSamples;
  }
  EXPECT_NEAR(irradiance, 6 * M_PI / 5,
              0.03);  // pi L sin^2, sin^2 = 1 / (1 + 4); 5 standard errors
  EXPECT_THROW(makeAreaLight(Disk(false), {}), SceneError);
  EXPECT_THROW(makeAreaLight(disk, {integers("nsamples", {0})}), SceneError);
  AreaLight::FactoryContext context;
  context.shape = &disk;
  context.quick = true;
  EXPECT_EQ(make<AreaLight>("diffuse", {integers("nsamples", {10})}, context)->sampleCount(), 2);
}

TEST(Light, ImportanceBoundsTheIrradiance) {
  const Disk disk;
  std::vector<std::unique_ptr<Light>> lights;
  lights.push_back(makeLight("point", {points("from", {{1, 2, 3}})}));
  lights.push_back(makeLight("spot", {points("from", {{1, 2, 3}}), points("to", {{0, 0, 0}})}));
  lights.push_back(
      makeLight("projection", {floats("fov", {50})}, Transform::translate({1, 1, -2})));
  lights.push_back(makeLight("goniometric", {string("mapname", writeMap("gonio2.exr", 8, 4))}));
  lights.push_back(makeAreaLight(disk, {}));
  lights.push_back(makeLight("distant", {}));
  lights.push_back(makeLight("infinite", {}));
  Rng rng(4);
  int zeros = 0;
  for (int i = 0; i < 2000; ++i)
    for (const auto& light : lights) {
      Bounds3 region;
      const Vec3 center =
          8.f * Vec3(rng.uniform() - 0.5f, rng.uniform() - 0.5f, rng.uniform() - 0.5f);
      region.extend(center);
      region.extend(center + 0.3f * Vec3(rng.uniform(), rng.uniform(), rng.uniform()));
      const float importance = light->importance(region);
      EXPECT_TRUE(std::isfinite(importance));
      EXPECT_GE(importance, 0);
      zeros += importance == 0;
      // Close to the light the importance is a mean, no bound.
      const bool isNear =
          light->position() && boundedInverseSquare(*light->position(), region) > 1 / sqr(0.6f);
      for (int k = 0; k < 4; ++k) {
        const Vec3 t(rng.uniform(), rng.uniform(), rng.uniform());
        const auto s = light->sampleLi(region.lo + t * region.diagonal(), rng.uniform2());
        if (!s) continue;
        EXPECT_GT(importance, 0);
        if (light->isDelta() && !isNear) {
          EXPECT_LE(s->L.luminance(), importance * 1.0001f);
        }
      }
    }
  EXPECT_GT(zeros, 100);              // cones that miss the region
  for (const auto& light : lights) {  // a region of no size, at the light
    const Vec3 p = light->position().value_or(Vec3(0));
    EXPECT_TRUE(std::isfinite(light->importance({p, p})));
    EXPECT_TRUE(std::isfinite(light->importance({Vec3(-1e6f), Vec3(1e6f)})));
  }
}

TEST(Light, SecondNames) {
  EXPECT_TRUE(makeLight("exinfinite", {})->isInfinite());
  const Disk disk;
  AreaLight::FactoryContext context;
  context.shape = &disk;
  EXPECT_TRUE(make<AreaLight>("area", {}, context));
}

TEST(Light, MapsThatAreMissing) {
  const int before = captureLog().warningCount();
  expectRelative(makeLight("goniometric", {})->power(), Rgb(4 * kPi), 1e-6f);
  makeLight("projection", {});
  EXPECT_EQ(captureLog().warningCount(), before + 2);
  for (const char* name : {"goniometric", "projection", "infinite"})
    EXPECT_THROW(makeLight(name, {string("mapname", "/nowhere/none.exr")}), SceneError) << name;
  EXPECT_THROW(makeLight("projection", {floats("fov", {0})}), SceneError);
  EXPECT_THROW(makeLight("projection", {floats("fov", {180})}), SceneError);
  EXPECT_NO_THROW(makeLight("projection", {floats("fov", {1e-3f})}));
  EXPECT_NO_THROW(makeLight("projection", {floats("fov", {179.99f})}));
}

}  // namespace
}  // namespace brume
