// SPDX-License-Identifier: Apache-2.0
// The volume integrators "single" and "emission".
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/make_plugin.h"
#include "support/media_scene.h"
#include "support/volumes.h"

namespace brume {
namespace {

using test::Estimate;
using test::MediumSpec;

std::unique_ptr<VolumeIntegrator> makeIntegrator(const Scene& scene, const char* name,
                                                 std::vector<Param> params) {
  VolumeIntegrator::FactoryContext context;
  context.scene = &scene;
  return test::make<VolumeIntegrator>(name, std::move(params), context);
}

std::unique_ptr<VolumeIntegrator> makeSingle(const Scene& scene, int samples) {
  return makeIntegrator(scene, "single", {test::integers("samples", {samples})});
}

template <class T, class... Rest>
std::vector<std::unique_ptr<T>> listOf(std::unique_ptr<T> first, Rest... rest) {
  std::vector<std::unique_ptr<T>> list;
  list.push_back(std::move(first));
  (list.push_back(std::move(rest)), ...);
  return list;
}

/// Single scattering along a ray by 1-D quadrature, from the interfaces of volume and light alone,
/// each tested by itself.
double quadrature(const Scene& scene, const Ray& ray, int channel) {
  const Volume& v = *scene.volume();
  const auto range = v.intersect(ray);
  return test::integrate(
      [&](double t) {
        const Vec3 p = ray(static_cast<float>(t));
        double sum = 0;
        for (const auto& light : scene.lights()) {
          const auto s = light->sampleLi(p, Vec2(0));
          if (!s) continue;
          const Ray shadow{p, s->wi, s->distance};
          sum += double{s->L[channel]} * double{v.phase(p, -ray.d, s->wi)[channel]} *
                 double{v.transmittance(shadow)[channel]};
        }
        const Interval before{range->t0, static_cast<float>(t)};
        return sum * double{v.at(p).sigma_s[channel]} *
               std::exp(-double{v.opticalDepth(ray, before)[channel]});
      },
      range->t0, range->t1, 500);
}

MediumSpec fog(float g = 0) {
  return {.sigma_a = Rgb(.1f, .2f, .4f),
          .sigma_s = Rgb(.5f, .8f, .3f),
          .p0 = Vec3(-1),
          .p1 = Vec3(1),
          .g = g};
}

const Ray kRay{{-.2f, .1f, -3}, normalize(Vec3(.1f, .05f, 1))};

void expectQuadrature(const Scene& scene, const Ray& ray = kRay) {
  // 16 x 4096 stratified samples of a smooth weight: far below 0.1 %.
  const Estimate e = test::estimate(*makeSingle(scene, 4096), ray, 16);
  for (int c = 0; c < 3; ++c) {
    const double expected = quadrature(scene, ray, c);
    EXPECT_NEAR(e.mean[c] / expected, 1, 1e-3);
    EXPECT_NEAR(e.Tr[c], scene.volume()->transmittance(ray)[c], 1e-6);
  }
  EXPECT_EQ(e.stats[Stat::NanRadiance] + e.stats[Stat::InfiniteRadiance] +
                e.stats[Stat::NegativeRadiance],
            0u);
}

TEST(Single, PointLight) {
  for (const float g : {0.f, .7f, -.5f})
    for (const Vec3& from : {Vec3(.3f, .4f, .2f), Vec3(3, 2, 0), Vec3(.01f, .21f, -.3f)})
      expectQuadrature(
          test::makeMediaScene(listOf(test::makeHomogeneous(fog(g))),
                               listOf(test::makePointLight({.from = from, .I = Rgb(1, 2, 3)}))));
}

TEST(Single, SpotLight) {
  expectQuadrature(
      test::makeMediaScene(listOf(test::makeHomogeneous(fog(.3f))),
                           listOf(test::makePointLight({.from = Vec3(0, 3, 0),
                                                        .I = Rgb(1.f),
                                                        .axis = normalize(Vec3(0, -1, .1f)),
                                                        .cosTotal = .96f,
                                                        .cosStart = .98f}))));
}

TEST(Single, SpotLightOfTheSceneLanguageIsClippedToItsCone) {
  Rng rng(3);
  const auto spot = test::make<Light>(
      "spot", {test::points("from", {Vec3(0, 3, 0)}), test::points("to", {Vec3(.2f, 0, .1f)}),
               test::floats("coneangle", {14}), test::floats("conedeltaangle", {3})});
  ASSERT_TRUE(spot);
  int lit = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 o(8 * rng.uniform() - 4, 8 * rng.uniform() - 4, 8 * rng.uniform() - 4);
    const Ray ray{o, test::randomDirection(rng)};
    const Interval part = spot->illuminated(ray, {.5f, 6.f});
    for (int k = 0; k < 32; ++k) {
      const float t = .5f + 5.5f * rng.uniform();
      const bool arrives = spot->sampleLi(ray(t), Vec2(0)).has_value();
      lit += arrives;
      // Nothing outside; what arrives inside is all of the cone but the rim's rounding.
      if (t < part.t0 || t > part.t1) {
        EXPECT_FALSE(arrives);
      }
      const float margin = 1e-4f * part.length();
      if (t > part.t0 + margin && t < part.t1 - margin) {
        EXPECT_TRUE(arrives);
      }
    }
  }
  EXPECT_GT(lit, 100);
  std::vector<std::unique_ptr<Light>> lights;
  lights.push_back(test::make<Light>(
      "spot", {test::points("from", {Vec3(0, 3, 0)}), test::points("to", {Vec3(.2f, 0, .1f)}),
               test::floats("coneangle", {14}), test::floats("conedeltaangle", {3})}));
  expectQuadrature(test::makeMediaScene(listOf(test::makeHomogeneous(fog())), std::move(lights)));
}

TEST(Single, DistantLight) {
  for (const float g : {0.f, .9f})
    expectQuadrature(
        test::makeMediaScene(listOf(test::makeHomogeneous(fog(g))),
                             listOf(test::makeDistantLight({1, -2, .5f}, Rgb(3, 2, 1)))));
}

TEST(Single, DistantLightInASlabHasAClosedForm) {
  // Light straight down, viewed straight up from below: all turns by 0, exp(-sigma_t s) in sum.
  const Scene scene = test::makeMediaScene(listOf(test::makeHomogeneous(fog(.5f))),
                                           listOf(test::makeDistantLight({0, 0, -1}, Rgb(1.f))));
  const Estimate e = test::estimate(*makeSingle(scene, 4096), {{0, 0, -2}, {0, 0, 1}}, 4);
  const double peak = 1.5 / (.5 * .5) / (4 * M_PI);
  for (int c = 0; c < 3; ++c) {
    const double sigma_s = fog().sigma_s[c], sigma_t = fog().sigma_t()[c];
    EXPECT_NEAR(e.mean[c], sigma_s * 2 * std::exp(-2 * sigma_t) * peak, 1e-3 * e.mean[c]);
  }
}

TEST(Single, EnvironmentInAForwardPeakedMedium) {
  // With a constant environment L outside a thin medium every direction brings L Tr(wi); for a
  // vanishing density Lv -> sigma_s s L whatever the phase function.
  for (const float g : {0.f, .9f, .99f}) {
    MediumSpec spec = fog(g);
    spec.sigma_a = Rgb(0.f);
    spec.sigma_s = Rgb(1e-5f, 2e-5f, 3e-5f);
    const Scene scene = test::makeMediaScene(listOf(test::makeHomogeneous(spec)),
                                             listOf(test::makeEnvironment(Rgb(2.f))));
    const Estimate e = test::estimate(*makeSingle(scene, 256), {{0, 0, -2}, {0, 0, 1}}, 200);
    for (int c = 0; c < 3; ++c) {
      const double expected = double{spec.sigma_s[c]} * 2 * 2;
      const double error = std::sqrt(e.variance[c] / 200);
      EXPECT_NEAR(e.mean[c], expected, 4 * error + 1e-4 * expected);
      EXPECT_LT(error, .01 * expected);
    }
  }
}

TEST(Single, HeterogeneousAndOverlappingMedia) {
  Rng rng(2);
  const auto density = test::randomDensities(6 * 5 * 7, rng, .3f);
  expectQuadrature(test::makeMediaScene(
      listOf(test::makeGrid(fog(.4f), 6, 5, 7, density), test::makeExponential(fog(), 1.f, 1.f)),
      listOf(test::makePointLight({.from = Vec3(.5f, .8f, .1f)}),
             test::makeDistantLight({0, -1, 0}, Rgb(.3f)))));
}

TEST(Single, ManyLightsAreChosenByTheirContribution) {
  std::vector<std::unique_ptr<Light>> lights;
  Rng rng(9);
  for (int i = 0; i < 50; ++i)
    lights.push_back(test::makePointLight(
        {.from = Vec3(20 * rng.uniform() - 10, 20 * rng.uniform() - 10, 2 * rng.uniform() - 1),
         .I = Rgb(rng.uniform(), rng.uniform(), rng.uniform())}));
  expectQuadrature(test::makeMediaScene(listOf(test::makeHomogeneous(fog())), std::move(lights)));
}

TEST(Single, EqualMediaOfAllKindsGiveTheSame) {
  const auto sceneOf = [](std::unique_ptr<Volume> v) {
    return test::makeMediaScene(listOf(std::move(v)),
                                listOf(test::makePointLight({.from = Vec3(.3f, .4f, .2f)})));
  };
  const Scene a = sceneOf(test::makeHomogeneous(fog(.5f)));
  const Scene b = sceneOf(test::makeExponential(fog(.5f), 1.f, 0.f));
  const Scene c = sceneOf(test::makeGrid(fog(.5f), 8, 9, 5, std::vector<float>(360, 1.f)));
  const Estimate ea = test::estimate(*makeSingle(a, 1024), kRay, 20);
  const Estimate eb = test::estimate(*makeSingle(b, 1024), kRay, 20);
  const Estimate ec = test::estimate(*makeSingle(c, 1024), kRay, 20);
  for (int k = 0; k < 3; ++k) {
    EXPECT_DOUBLE_EQ(ea.mean[k], eb.mean[k]);
    // The grid's distances are drawn in another way: agreement to the noise of 20480 of them.
    EXPECT_NEAR(ea.mean[k], ec.mean[k], 1e-3 * ea.mean[k]);
  }
}

TEST(Single, MarchingAgreesAndIsNoisier) {
  MediumSpec spec = fog();
  spec.Le = Rgb(.01f);
  const Scene scene = test::makeMediaScene(
      listOf(test::makeHomogeneous(spec)),
      listOf(test::makePointLight({.from = Vec3(.05f, .2f, .2f), .I = Rgb(1, 2, 3)})));
  constexpr int n = 4000;
  const auto march = makeIntegrator(
      scene, "single", {test::string("method", "march"), test::floats("stepsize", {.5f})});
  const Estimate a = test::estimate(*makeSingle(scene, 4), kRay, n);
  const Estimate b = test::estimate(*march, kRay, n);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(a.mean[c], b.mean[c], 4 * std::sqrt((a.variance[c] + b.variance[c]) / n));
    EXPECT_LT(4 * a.variance[c], b.variance[c]);  // both take about four distances per ray
  }
  EXPECT_EQ(a.Tr, b.Tr);
}

TEST(Single, ScaledScenesLookTheSame) {
  const auto render = [](float s) {
    MediumSpec spec = fog(.5f);
    spec.sigma_a *= 1 / s;
    spec.sigma_s *= 1 / s;
    spec.volumeToWorld = Transform::scale(s, s, s);
    const Scene scene = test::makeMediaScene(
        listOf(test::makeHomogeneous(spec)),
        listOf(test::makePointLight({.from = Vec3(.3f, .4f, .2f) * s, .I = Rgb(s * s)})));
    return test::estimate(*makeSingle(scene, 16), {kRay.o * s, kRay.d}, 10).mean[1];
  };
  const double expected = render(1);
  for (const float s : {1e-6f, 1e-3f, 1e3f, 1e6f})
    EXPECT_NEAR(render(s) / expected, 1, 1e-4);  // same random numbers
}

TEST(Single, OpticalDepthsFromTinyToHuge) {
  for (const float tau : {1e-6f, 1e-2f, 10.f, 1e4f}) {
    MediumSpec spec = fog();
    spec.sigma_a = Rgb(0.f);
    spec.sigma_s = Rgb(.5f, .25f, 1.f) * tau;
    const Scene scene = test::makeMediaScene(listOf(test::makeHomogeneous(spec)),
                                             listOf(test::makeDistantLight({0, 0, 1}, Rgb(1.f))));
    // Lit along the view: Lv = sigma_s p Int exp(-2 sigma_t t) dt... of light from behind the
    // viewer.
    const Estimate e = test::estimate(*makeSingle(scene, 2048), {{0, 0, -2}, {0, 0, 1}}, 16);
    for (int c = 0; c < 3; ++c) {
      const double depth = 2 * double{spec.sigma_s[c]};
      EXPECT_NEAR(e.mean[c] / (-std::expm1(-2 * depth) / 2 / (4 * M_PI)), 1, 2e-3) << tau;
    }
  }
}

TEST(Single, RayThroughALightIsFinite) {
  const Scene scene = test::makeMediaScene(listOf(test::makeHomogeneous(fog())),
                                           listOf(test::makePointLight({.from = Vec3(0, 0, .1f)})));
  const Estimate e = test::estimate(*makeSingle(scene, 16), {{0, 0, -2}, {0, 0, 1}}, 50);
  EXPECT_TRUE(std::isfinite(e.mean[0]));
  EXPECT_EQ(e.stats[Stat::NanRadiance] + e.stats[Stat::InfiniteRadiance], 0u);
}

TEST(Single, NoWorkWhereNothingScatters) {
  const Scene absorbing = test::makeMediaScene(listOf(test::makeHomogeneous({.sigma_a = Rgb(1.f)})),
                                               listOf(test::makePointLight({.from = Vec3(3)})));
  const Estimate e = test::estimate(*makeSingle(absorbing, 4), {{.5f, .5f, -1}, {0, 0, 1}}, 4);
  EXPECT_EQ(e.mean[0], 0);
  EXPECT_FLOAT_EQ(e.Tr.r, std::exp(-1.f));
  EXPECT_EQ(e.stats[Stat::ShadowRays], 0u);
  EXPECT_EQ(e.stats[Stat::VolumeSamples], 0u);
  const Scene empty = test::makeMediaScene({}, {});
  EXPECT_EQ(test::estimate(*makeSingle(empty, 4), kRay, 1).Tr, Rgb(1.f));
}

TEST(Single, SurfacesEndTheRay) {
  const Scene scene = test::makeMediaScene(
      listOf(test::makeHomogeneous({.sigma_a = Rgb(1.f), .Le = Rgb(2.f)})), {});
  const Ray ray{{.5f, .5f, -1}, {0, 0, 1}, 1.5f};
  const Estimate e = test::estimate(*makeSingle(scene, 4), ray, 1);
  EXPECT_NEAR(e.mean[0], 2 * (1 - std::exp(-.5)), 1e-6);
  EXPECT_FLOAT_EQ(e.Tr.r, std::exp(-.5f));
}

TEST(Single, StepSizeIsSpokenOf) {
  const Scene scene = test::makeMediaScene(listOf(test::makeHomogeneous(fog())), {});
  makeIntegrator(scene, "single", {test::floats("stepsize", {.5f})});
  EXPECT_THAT(test::captureLog().captured(),
              testing::Contains(testing::HasSubstr("\"stepsize\" has no effect")));
  EXPECT_THROW(makeIntegrator(scene, "single", {test::floats("stepsize", {0.f})}), SceneError);
  EXPECT_THROW(makeIntegrator(scene, "single",
                              {test::floats("stepsize", {1e-9f}), test::string("method", "march")}),
               SceneError);
  EXPECT_THROW(makeIntegrator(scene, "single", {test::integers("samples", {0})}), SceneError);
}

TEST(Emission, IsExactAndIgnoresLights) {
  MediumSpec spec = fog();
  spec.Le = Rgb(1, 2, 3);
  const Scene scene = test::makeMediaScene(listOf(test::makeHomogeneous(spec)),
                                           listOf(test::makePointLight({.from = Vec3(3)})));
  const auto integrator = makeIntegrator(scene, "emission", {test::floats("stepsize", {.1f})});
  const Estimate e = test::estimate(*integrator, {{0, 0, -2}, {0, 0, 1}}, 1);
  for (int c = 0; c < 3; ++c) {
    const double sigma_t = spec.sigma_t()[c];
    EXPECT_NEAR(e.mean[c], double{spec.Le[c]} * (1 - std::exp(-2 * sigma_t)) / sigma_t, 1e-6);
    EXPECT_NEAR(e.Tr[c], std::exp(-2 * sigma_t), 1e-6);
  }
  EXPECT_EQ(e.stats[Stat::ShadowRays], 0u);
}

}  // namespace
}  // namespace brume
