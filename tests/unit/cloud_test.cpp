// SPDX-License-Identifier: Apache-2.0
// Clouds: bounds of their noise, tracking against quadrature, and every method against the same
// field in a grid. |z| < 4 fails by chance once in 16,000.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/medium_along_ray.h"
#include "core/tracking_key.h"
#include "support/estimate.h"
#include "support/make_plugin.h"
#include "support/render_text.h"
#include "support/volumes.h"
#include "transport/free_flight.h"
#include "volumes/gradient_noise.h"

namespace brume {
namespace {

using namespace test;

constexpr double kMaxZ = 4;

TEST(GradientNoise, StaysWithinTheRangeOfItsBox) {
  Rng rng(1);
  const FractalNoise noise(7, 4, 0.6);
  double widest = 0;
  for (int i = 0; i < 400; ++i) {
    const double size = std::exp2(-8 * rng.uniformDouble());
    Bounds3d box;
    for (int a = 0; a < 3; ++a) {
      box.lo[a] = 20 * rng.uniformDouble() - 10;
      box.hi[a] = box.lo[a] + size * rng.uniformDouble();
    }
    const ValueRange range = noise.range(box);
    for (int k = 0; k < 50; ++k) {
      const Vec3d u(rng.uniformDouble(), rng.uniformDouble(), rng.uniformDouble());
      const double v = noise.value(box.lo + u * (box.hi - box.lo));
      ASSERT_GE(v, range.lo - 1e-12);
      ASSERT_LE(v, range.hi + 1e-12);
    }
    if (size < 1.0 / 64) widest = std::max(widest, range.hi - range.lo);
  }
  // Small boxes have a small range: the gradient of the finest octave, of weight 0.1, is about 2
  // per 1/8.
  EXPECT_LT(widest, 0.25);
}

std::vector<Param> cloudParams(const std::string& shape = "ball", int octaves = 3) {
  return {color("sigma_a", {.1f, 0, .4f}), color("sigma_s", {2, 3, 1}),
          points("p0", {Vec3(-1)}),        points("p1", {Vec3(1)}),
          floats("frequency", {1.5f}),     integers("octaves", {octaves}),
          floats("density", {2}),          string("shape", shape),
          floats("threshold", {.4f}),      integers("seed", {3})};
}
std::unique_ptr<Volume> makeCloud(const std::string& shape = "ball", int octaves = 3) {
  return make<Volume>("cloud", cloudParams(shape, octaves));
}

const std::array<Ray, 3> kRays = {Ray{Vec3(-3, .1f, .2f), Vec3(1, 0, 0)},
                                  Ray{Vec3(.2f, -.1f, .1f), normalize(Vec3(1, 2, -1.5f))},
                                  Ray{Vec3(2, 2, 2), normalize(Vec3(-1, -1.05f, -.95f))}};

/// Optical depth from the start of the range to t, by quadrature of the density.
Vec3d exactDepth(const Volume& volume, const Ray& ray, double a, double b) {
  Vec3d depth;
  for (int c = 0; c < 3; ++c)
    depth[c] = integrate(
        [&](double t) { return double{volume.at(ray(static_cast<float>(t))).sigma_t()[c]}; }, a, b,
        200);
  return depth;
}

TEST(Cloud, TransmittanceIsThatOfItsDensity) {
  for (const std::string shape : {"ball", "box"}) {
    const auto cloud = makeCloud(shape);
    for (const Ray& ray : kRays) {
      const auto range = cloud->intersect(ray);
      ASSERT_TRUE(range);
      const Vec3d exact = exactDepth(*cloud, ray, double{range->t0}, double{range->t1});
      constexpr int kCount = 8000;
      double sum[2][3] = {}, squares[2][3] = {};
      for (int i = 0; i < kCount; ++i) {
        trackingKey() = static_cast<std::uint64_t>(i);
        const Rgb Tr[2] = {cloud->transmittance(ray),
                           MediumAlongRay(*cloud, ray, *range).transmittance()};
        for (int k = 0; k < 2; ++k)
          for (int c = 0; c < 3; ++c) {
            sum[k][c] += double{Tr[k][c]} / kCount;
            squares[k][c] += sqr(double{Tr[k][c]}) / kCount;
          }
      }
      for (int k = 0; k < 2; ++k)
        for (int c = 0; c < 3; ++c) {
          // What one ray in a thousand lets through, so few realisations do not show.
          if (exact[c] > 5) continue;
          const double error = std::sqrt((squares[k][c] - sqr(sum[k][c])) / kCount);
          EXPECT_LT(std::abs(sum[k][c] - std::exp(-exact[c])), kMaxZ * error + 1e-6)
              << shape << " " << k << " " << c << ": " << sum[k][c] << " +- " << error;
        }
    }
  }
}

TEST(Cloud, FlightsEndWhereTheyShould) {
  // Histogram of free flights, weighted for each channel, against Tr(a) - Tr(b); with a second
  // medium that overlaps.
  MediumSpec spec;
  spec.sigma_s = Rgb(.5f, .2f, 1);
  spec.p0 = Vec3(-.5f);
  spec.p1 = Vec3(2);
  const auto cloud = makeCloud("ball", 4), other = makeHomogeneous(spec);
  const auto both = makeAggregateVolume({cloud.get(), other.get()});
  for (const Volume* volume : std::vector<const Volume*>{cloud.get(), both.get()})
    for (const Ray& ray : kRays) {
      const auto range = volume->intersect(ray);
      ASSERT_TRUE(range);
      const double a = double{range->t0}, b = double{range->t1};
      constexpr int kBins = 12, kCount = 15000;
      double sum[3][kBins + 1] = {}, squares[3][kBins + 1] = {};
      Rng rng(4);
      for (int i = 0; i < kCount; ++i) {
        trackingKey() = static_cast<std::uint64_t>(i);
        const MediumAlongRay medium(*volume, ray, *range);
        const FreeFlight flight =
            sampleFreeFlight(medium, Rgb(.5f, .3f, .2f), rng.uniform(), rng.uniform());
        const int bin =
            flight.t
                ? std::min(kBins - 1, static_cast<int>((double{*flight.t} - a) / (b - a) * kBins))
                : kBins;
        for (int c = 0; c < 3; ++c) {
          sum[c][bin] += double{flight.weight[c]} / kCount;
          squares[c][bin] += sqr(double{flight.weight[c]}) / kCount;
        }
      }
      Vec3d depth(0);
      for (int i = 0; i <= kBins; ++i) {
        const double t0 = a + (b - a) * i / kBins, t1 = a + (b - a) * (i + 1) / kBins;
        const Vec3d before = depth;
        if (i < kBins) depth += exactDepth(*volume, ray, t0, t1);
        for (int c = 0; c < 3; ++c) {
          const double exact = std::exp(-before[c]) - (i < kBins ? std::exp(-depth[c]) : 0.0);
          // Of rare events the scatter that was seen says too little.
          if (exact < 5e-3) continue;
          const double error = std::sqrt((squares[c][i] - sqr(sum[c][i])) / kCount);
          EXPECT_LT(std::abs(sum[c][i] - exact), kMaxZ * error)
              << "bin " << i << " channel " << c << ": " << sum[c][i] << ", exact " << exact;
        }
      }
    }
}

TEST(Cloud, BoundsHoldAtTheEndsOfTheParameters) {
  // A density above its bound stops the program.
  for (const int octaves : {1, 16})
    for (const float softness : {1e-3f, 10.f})
      for (const float wispiness : {0.f, 5.f}) {
        auto params = cloudParams("ball", octaves);
        params.push_back(floats("softness", {softness}));
        params.push_back(floats("wispiness", {wispiness}));
        params.push_back(floats("gain", {1}));
        const auto cloud = make<Volume>("cloud", std::move(params));
        Rng rng(9);
        for (int i = 0; i < 300; ++i) {
          const Ray ray{randomDirection(rng) * 2.f, randomDirection(rng)};
          const Rgb Tr = cloud->transmittance(ray);
          EXPECT_GE(Tr.minChannel(), 0);
          EXPECT_LE(Tr.maxChannel(), 1);
        }
      }
}

TEST(Cloud, DoesNotEmit) {
  const auto cloud = makeCloud();
  EXPECT_FALSE(cloud->isEmissive());
  EXPECT_TRUE(cloud->isTracked());
}

// Rendered by every method, against a grid of the same density.

std::string cloudText() {
  return "Volume \"cloud\" \"color sigma_a\" [.1 0 .4] \"color sigma_s\" [2 3 1] \"point p0\" [-1 "
         "-1 "
         "-1] \"point p1\" [1 1 1]\n"
         "  \"float frequency\" 1.5 \"integer octaves\" 2 \"float density\" 2 \"float threshold\" "
         ".4 "
         "\"integer seed\" 3\n";
}
/// The same on a grid, fine against its smallest features.
std::string gridText() {
  constexpr int n = 48;
  const auto cloud = makeCloud("ball", 2);
  std::string text = fmt::format(
      "Volume \"volumegrid\" \"color sigma_a\" [.1 0 .4] \"color sigma_s\" [2 3 1] \"point p0\" "
      "[-1 "
      "-1 -1] \"point p1\" [1 1 1]\n"
      "  \"integer nx\" {0} \"integer ny\" {0} \"integer nz\" {0} \"float density\" [",
      n);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const auto at = [](int i) { return (static_cast<float>(i) + .5f) * 2 / n - 1; };
        text += fmt::format(" {:.5g}", cloud->at({at(x), at(y), at(z)}).sigma_s.r / 2);
      }
  return text + "]\n";
}

Estimate render(const std::string& method, const std::string& world, int samples) {
  const std::string text = fmt::format(
      "LookAt 2 1.5 3  .1 .1 0  0 1 0\nCamera \"perspective\" \"float fov\" [4]\n"
      "Film \"image\" \"integer xresolution\" [8] \"integer yresolution\" [8]\n"
      "PixelFilter \"box\" Sampler \"random\" \"integer pixelsamples\" [{}]\n{}\nWorldBegin\n{}\n"
      "WorldEnd\n",
      samples, method, world);
  // The scatter of renders with different seeds: photon methods have pixels that depend on each
  // other.
  constexpr int kRenders = 5;
  double sum = 0, squares = 0;
  for (int i = 0; i < kRenders; ++i) {
    RenderSettings settings;
    settings.seed = static_cast<std::uint64_t>(i);
    const double v = double{meanOf(renderText(text, settings).image).g};
    sum += v / kRenders;
    squares += v * v / kRenders;
  }
  return {sum, std::sqrt((squares - sum * sum) / (kRenders - 1))};
}

TEST(Cloud, EveryMethodShowsWhatItShowsInAGrid) {
  const std::string light = "LightSource \"point\" \"point from\" [1.5 2 .5] \"color I\" [5 5 5]\n";
  const std::string grid = gridText();
  struct Case {
    std::string method;
    int samples;
  };
  for (const Case& c : std::vector<Case>{
           {"GlobalIntegrator \"volpath\"", 8},
           {"VolumeIntegrator \"single\"", 2},
           {"GlobalIntegrator \"bre\" \"integer photons\" 3000", 1},
           {"GlobalIntegrator \"vpm\" \"integer photons\" 3000", 1},
           {"GlobalIntegrator \"pvpm\" \"integer photonsperpass\" 12000 \"integer passes\" 1",
            1}}) {
    const Estimate cloud = render(c.method, light + cloudText(), c.samples),
                   baked = render(c.method, light + grid, c.samples);
    // Trilinear interpolation between voxels of 1/36 of a feature: a few tenths of a per cent.
    EXPECT_LT(std::abs(cloud.mean - baked.mean),
              kMaxZ * std::hypot(cloud.standardError, baked.standardError) + 4e-3 * baked.mean)
        << c.method << ": " << cloud.mean << " +- " << cloud.standardError << ", grid "
        << baked.mean << " +- " << baked.standardError;
    EXPECT_LT(cloud.standardError, 0.1 * cloud.mean) << c.method;
  }
}

TEST(Cloud, WhiteFurnace) {
  // The camera rays are the same in every sample but for a thousandth of a degree.
  for (const std::string colours : {"[4 4 4]", "[1 4 9]"}) {
    const std::string text = fmt::format(
        "LookAt 2 1.5 3  .1 .1 0  0 1 0\nCamera \"perspective\" \"float fov\" [.001]\n"
        "Film \"image\" \"integer xresolution\" [16] \"integer yresolution\" [16]\n"
        "Sampler \"random\" \"integer pixelsamples\" [8]\nGlobalIntegrator "
        "\"volpath\"\nWorldBegin\n"
        "LightSource \"infinite\" \"color L\" [1 1 1] Volume \"cloud\" \"color sigma_s\" {} "
        "\"point p0\" [-1 -1 -1] \"point p1\" [1 1 1] \"float density\" 2\nWorldEnd\n",
        colours);
    const auto image = renderText(text).image;
    for (const char* channel : {"R", "G", "B"}) {
      const Estimate e = estimateOf(image, channel);
      EXPECT_LT(std::abs(e.z(1)), kMaxZ) << colours << " mean " << e.mean;
      EXPECT_LT(e.standardError, 0.05);
    }
  }
}

TEST(Cloud, TechniquesAgreeOnALightInside) {
  const std::string world = "LightSource \"point\" \"point from\" [.2 .3 .1]\n" + cloudText();
  const Estimate with = render("GlobalIntegrator \"volpath\"", world, 16),
                 without = render("GlobalIntegrator \"volpath\" \"bool equiangular\" \"false\"",
                                  world, 16);
  EXPECT_LT(std::abs(with.z(without)), kMaxZ) << with.mean << " " << without.mean;
  EXPECT_LT(with.standardError, 0.1 * with.mean);
}

}  // namespace
}  // namespace brume
