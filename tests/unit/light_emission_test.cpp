// SPDX-License-Identifier: Apache-2.0
// sampleEmission of every light against sampleLi: the light paths that cross a small ball carry the
// fluence that the ball's points see.
#include <gtest/gtest.h>

#include "core/light.h"
#include "core/rng.h"
#include "core/sampling.h"
#include "support/estimate.h"
#include "support/make_plugin.h"

namespace brume {
namespace {

using namespace test;

const Bounds3 kScene{Vec3(-4), Vec3(4)};

/// A 4 x 2 map of different values on disk.
std::string mapFile() {
  static const std::string path = testing::TempDir() + "brume_emission_map.pfm";
  LayeredImage image;
  image.displaySize = {4, 2};
  image.dataWindow = {{0, 0}, {4, 2}};
  Rng rng(3);
  for (const char* c : {"R", "G", "B"})
    for (int i = 0; i < 8; ++i) image.channels[c].push_back(i == 1 ? 0.f : rng.uniform());
  writeImage(path, image, PixelPrecision::Float);
  return path;
}

struct LightCase {
  std::string name;
  std::unique_ptr<Shape> shape;
  std::unique_ptr<Light> light;
  bool isStretched = false;
};

std::vector<LightCase> allLights() {
  std::vector<LightCase> cases;
  const auto add = [&](const char* name, std::vector<Param> params,
                       const Transform& transform = {}) {
    Light::FactoryContext context;
    context.lightToWorld = transform;
    cases.push_back(
        {name, nullptr, make<Light>(name, std::move(params), context), transform.hasScale()});
  };
  const Transform turned = Transform::translate({1, 2, 3}) * Transform::rotate(140, {1, 2, 0});
  const Transform stretched = turned * Transform::scale(1, 2, .5);
  add("point", {color("I", {1, 2, 3}), points("from", {{1, 2, 3}})});
  add("spot", {points("from", {{1, 2, 3}}), points("to", {{.2f, 0, 0}}), floats("coneangle", {50}),
               floats("conedeltaangle", {30})});
  add("spot",
      {points("from", {{1, 2, 3}}), points("to", {{-1, 0, 0}}), floats("coneangle", {120})});
  add("spot", {points("from", {{0, 0, 0}}), points("to", {{0, 0, 1}}), floats("coneangle", {60})},
      stretched);
  add("distant", {color("L", {1, 2, 3}), points("from", {{1, 1, 1}})});
  add("infinite", {color("L", {1, 2, 3})});
  add("infinite", {string("mapname", mapFile())}, turned);
  add("goniometric", {color("I", {1, 2, 3})}, turned);
  add("goniometric", {string("mapname", mapFile())}, turned);
  add("goniometric", {string("mapname", mapFile())}, stretched);
  add("projection", {string("mapname", mapFile()), floats("fov", {70})}, turned);
  add("projection", {string("mapname", mapFile()), floats("fov", {70})}, stretched);
  Shape::FactoryContext context;
  context.objectToShape = Transform::translate({1, 2, 3}) * Transform::rotate(150, {1, 0, 0});
  auto disk = make<Shape>("disk", {floats("radius", {1})}, context);
  AreaLight::FactoryContext areaContext;
  areaContext.shape = disk.get();
  auto area = make<AreaLight>("diffuse", {color("L", {1, 2, 3})}, areaContext);
  cases.push_back({"diffuse", std::move(disk), std::move(area)});
  for (LightCase& c : cases) c.light->setSceneBounds(kScene);
  return cases;
}

struct Moments {
  double sum = 0, squares = 0;
  int n = 0;
  void add(double v) {
    sum += v;
    squares += v * v;
    ++n;
  }
  Estimate estimate() const {
    const double mean = sum / n;
    return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / n)};
  }
};

/// Mean over the ball of the fluence, by sampling the light from random points in it.
Estimate fluenceSeen(const Light& light, const Ball& ball, int n) {
  Moments moments;
  Rng rng(11);
  for (int i = 0; i < n; ++i) {
    const Vec3 p =
        ball.center + ball.radius * std::cbrt(rng.uniform()) * sampleUniformSphere(rng.uniform2());
    const auto s = light.sampleLi(p, rng.uniform2());
    moments.add(s && s->pdf > 0 ? double{s->L.g} / double{s->pdf} : 0.0);
  }
  return moments.estimate();
}

/// The same by the length that light paths travel in the ball.
Estimate fluenceCarried(const Light& light, const Ball& ball, const Ball& target, int n) {
  Moments moments;
  Rng rng(17);
  const double volume = 4.0 / 3 * M_PI * std::pow(double{ball.radius}, 3);
  for (int i = 0; i < n; ++i) {
    const auto e = light.sampleEmission(target, {rng.uniform2(), rng.uniform2()});
    double length = 0;
    if (e) {
      EXPECT_NEAR(lengthSquared(e->d), 1, 1e-5);
      const Vec3d o = Vec3d(e->o) - Vec3d(ball.center), d(e->d);
      const double b = dot(o, d), q = b * b - dot(o, o) + sqr(double{ball.radius});
      if (q > 0) length = std::max(0.0, -b + std::sqrt(q)) - std::max(0.0, -b - std::sqrt(q));
    }
    moments.add(e ? double{e->power.g} * length / volume : 0.0);
  }
  return moments.estimate();
}

TEST(LightEmission, CarriesWhatPointsSee) {
  const Ball all = ballAround(kScene), here{Vec3(-.5f, .3f, -.2f), .7f}, far{Vec3(-2, -3, -3), .5f};
  for (const LightCase& c : allLights())
    for (const Ball& ball : {here, far})
      for (const Ball& target : {all, Ball{ball.center, 1.2f * ball.radius}}) {
        const Estimate seen = fluenceSeen(*c.light, ball, 20'000);
        const Estimate carried = fluenceCarried(*c.light, ball, target, 100'000);
        // Fails by chance once in 16,000 per comparison; where both are exact, rounding is left.
        EXPECT_LE(std::abs(seen.mean - carried.mean),
                  4 * std::hypot(seen.standardError, carried.standardError) + 1e-4 * seen.mean)
            << c.name << " seen " << seen.mean << " carried " << carried.mean;
      }
}

TEST(LightEmission, PowerOfPathsIsThePowerOfTheLight) {
  // Towards a target that no direction misses; lights around the scene send what meets it.
  for (const LightCase& c : allLights()) {
    Moments moments;
    Rng rng(23);
    const Ball target = c.light->isInfinite() ? ballAround(kScene) : Ball{Vec3(1, 2, 3), 100.f};
    for (int i = 0; i < 50'000; ++i) {
      const auto e = c.light->sampleEmission(target, {rng.uniform2(), rng.uniform2()});
      moments.add(e ? double{e->power.g} : 0.0);
    }
    const Estimate e = moments.estimate();
    EXPECT_GT(c.light->powerToward(target).g, 0) << c.name;
    // power() of parallel light is that through the scene, and of a stretched light that of the
    // light before the stretch.
    if (c.name == "distant" || c.isStretched) continue;
    EXPECT_LE(std::abs(e.mean - double{c.light->power().g}), 4 * e.standardError + 2e-3 * e.mean)
        << c.name;
  }
}

TEST(LightEmission, EveryLightOfTheRegistryEmits) {
  std::vector<std::string> tested{"diffuse"};
  for (const LightCase& c : allLights()) tested.push_back(c.name);
  for (const std::string& name : Registry<Light>::names())
    EXPECT_TRUE(name == "exinfinite" || std::ranges::find(tested, name) != tested.end()) << name;
}

}  // namespace
}  // namespace brume
