// SPDX-License-Identifier: Apache-2.0
// pvpm against closed forms, volpath and itself.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include "core/parallel.h"
#include "support/estimate.h"
#include "support/make_plugin.h"
#include "support/render_text.h"

namespace brume {
namespace {

const std::string kAhead = "0 0 -4 0 0 0 0 1 0";
std::string scene(const std::string& integrator, const std::string& world, int size = 16,
                  const std::string& lookAt = kAhead, double fov = 30, int samples = 1) {
  return fmt::format(
      "LookAt {}\nCamera \"perspective\" \"float fov\" [{}]\n"
      "Film \"image\" \"integer xresolution\" [{}] \"integer yresolution\" [{}]\n"
      "Sampler \"random\" \"integer pixelsamples\" [{}]\nGlobalIntegrator {}\n"
      "WorldBegin\n{}\nWorldEnd\n",
      lookAt, fov, size, size, samples, integrator, world);
}

const std::string kPoint = "LightSource \"point\" \"point from\" [.3 .9 -.4] \"color I\" [1 2 3] ";
std::string fog(const std::string& coefficients, const std::string& kind = "homogeneous") {
  return fmt::format("Volume \"{}\" {} \"point p0\" [-1 -1 -1] \"point p1\" [1 1 1] ", kind,
                     coefficients);
}
const std::string kFog =
    fog("\"color sigma_s\" [.8 1 1.2] \"color sigma_a\" [.1 .1 .2] \"float g\" .5");

void expectSameImages(const LayeredImage& a, const LayeredImage& b) {
  for (const char* c : {"R", "G", "B"}) EXPECT_EQ(a.channels.at(c), b.channels.at(c)) << c;
}

TEST(Pvpm, ThreadsDoNotMatter) {
  const std::string text =
      scene("\"pvpm\" \"integer passes\" 3 \"integer photonsperpass\" 3000",
            kPoint + kFog + "Material \"matte\" Translate 0 -2 0 Rotate 90 1 0 0 Shape \"disk\" ");
  std::optional<LayeredImage> first;
  for (int threads : {1, 2, 7}) {
    setThreadCount(threads);
    const LayeredImage image = renderText(text).image;
    if (!first) first = image;
    expectSameImages(image, *first);
  }
  setThreadCount(0);
}

TEST(Pvpm, LookupsGiveTheSameImage) {
  // Phase functions without lobes go pair by pair in every lookup: the same pairs in the same
  // order, so the same bits. Else the quadtree has kernels of its own: equal to 1e-5.
  const std::string thinning = "\"color sigma_s\" [1 1 1] \"float b\" .7";
  for (const auto& [medium, isExact] :
       {std::pair(fog(thinning + " \"string phase\" \"rayleigh\"", "exponential"), true),
        std::pair(fog(thinning, "exponential"), false), std::pair(kFog, false),
        std::pair(kFog + fog(thinning, "exponential"), false)}) {
    const auto render = [&medium = medium](const std::string& lookup) {
      return renderText(scene("\"pvpm\" \"integer passes\" 2 \"integer photonsperpass\" 3000 "
                              "\"string lookup\" \"" +
                                  lookup + "\"",
                              kPoint + medium))
          .image;
    };
    const LayeredImage tree = render("quadtree"), linear = render("linear");
    if (isExact) expectSameImages(tree, linear);
    expectSameImages(render("raster"), linear);
    for (const char* c : {"R", "G", "B"})
      for (std::size_t i = 0; i < tree.channels.at(c).size(); ++i)
        EXPECT_NEAR(tree.channels.at(c)[i], linear.channels.at(c)[i],
                    1e-5f * linear.channels.at(c)[i])
            << medium;
  }
}

/// Mean of the image's middle over seeds, with its standard error.
Estimate meanOverSeeds(const std::string& text, int seeds) {
  double sum = 0, squares = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    RenderSettings settings;
    settings.seed = static_cast<std::uint64_t>(seed);
    const double v = double{meanOf(renderText(text, settings).image).g};
    sum += v;
    squares += v * v;
  }
  const double mean = sum / seeds;
  return {mean, std::sqrt(std::max(0.0, squares / seeds - mean * mean) / (seeds - 1))};
}

TEST(Pvpm, AgreesWithVolpathAtSmallRadius) {
  // All that photons can carry: unscattered light by photons too, through a glass ball, off a
  // floor. The view is narrow and inside the fog, the radius small: no boundary is in reach.
  const std::string floor =
      "AttributeBegin Material \"matte\" \"color Kd\" [.6 .6 .6] Translate 0 -1.5 0 Rotate -90 1 0 "
      "0 "
      "Shape \"disk\" \"float radius\" 4 AttributeEnd ";
  for (const bool direct : {false, true}) {
    const std::string world = kPoint + kFog + floor, look = "0 .2 -4 0 -.2 0 0 1 0";
    const Estimate truth = meanOverSeeds(scene("\"volpath\"", world, 8, look, 4, 128), 16);
    const Estimate pvpm =
        meanOverSeeds(scene(fmt::format("\"pvpm\" \"integer passes\" 8 \"integer photonsperpass\" "
                                        "4000 \"float radius\" .03 "
                                        "\"float surfaceradius\" .1 \"bool directvolume\" \"{}\"",
                                        direct),
                            world, 8, look, 4),
                      16);
    EXPECT_LT(std::abs(pvpm.z(truth)), 4) << direct << " " << pvpm.mean << " " << truth.mean;
    EXPECT_LT(pvpm.standardError, 0.05 * truth.mean);
    EXPECT_LT(truth.standardError, 0.02 * truth.mean);
  }
}

/// A soft cone of light, blurred by a radius like its own: the passes' variance alone would tell a
/// tenth of the error.
TEST(Pvpm, EstimatedErrorCountsTheBlur) {
  const std::string world =
      "LightSource \"spot\" \"point from\" [0 4 0] \"point to\" [0 0 0] \"float coneangle\" 12 "
      "\"float conedeltaangle\" 12 \"color I\" [20 20 20] " +
      fog("\"color sigma_s\" [.1 .1 .1] \"color sigma_a\" [.1 .1 .2] \"float g\" .3");
  const LayeredImage truth =
      renderText(scene("\"volpath\" \"integer maxdepth\" 1", world, 12, kAhead, 30, 2000)).image;
  RenderSettings settings;
  settings.passes = 256;
  settings.targetError = 1e-9;
  const RenderResult result =
      renderText(scene("\"pvpm\" \"integer photonsperpass\" 2000 \"float radius\" .45 "
                       "\"integer maxdepth\" 0 \"bool directvolume\" \"false\"",
                       world, 12, kAhead, 30),
                 settings);
  const double mean = double{meanOf(truth).average()};
  double error = 0, variance = 0, count = 0;
  for (const std::string c : {"R", "G", "B"})
    for (std::size_t i = 0; i < truth.channels.at(c).size(); ++i) {
      const double t = double{truth.channels.at(c)[i]}, square = sqr(t) + kDarkShare * sqr(mean);
      error += sqr(double{result.image.channels.at(c)[i]} - t) / square;
      variance += double{result.image.channels.at("variance." + c)[i]} / square;
      count += 1;
    }
  ASSERT_TRUE(result.estimatedError);
  const double ratio = *result.estimatedError / std::sqrt(error / count);
  EXPECT_LT(ratio, 1.5);
  EXPECT_GT(ratio, 1 / 1.5);
  EXPECT_LT(variance, 0.04 * error);
}

TEST(Pvpm, OnePassIsTheBeamRadianceEstimateOfItsMap) {
  // The same photons, camera rays and radius, all scattered light by photons: the images are equal
  // but for the order of float sums.
  const std::string file =
      testing::TempDir() + fmt::format("brume_pvpm_bre_{}.photons", ::getpid());
  std::string grid;
  for (int i = 0; i < 64; ++i)
    grid += fmt::format(" {}", i % 4 == 0 ? 0 : 0.2 + 0.1 * (i * 7 % 11));
  const std::string smoke =
      fog("\"color sigma_s\" [1 2 3] \"color sigma_a\" [.1 .1 .1] \"float g\" -.3 \"integer nx\" 4 "
          "\"integer ny\" 4 "
          "\"integer nz\" 4 \"float density\" [" +
              grid + "]",
          "volumegrid");
  for (const std::string& medium :
       {kFog, smoke, kFog + smoke,
        fog("\"color sigma_s\" [1 1 1] \"float b\" .7", "exponential")}) {
    const auto render = [&](const std::string& method) {
      return renderText(
                 fmt::format(
                     "LookAt 0 .2 -2.4 0 0 0 0 1 0\nCamera \"perspective\" \"float fov\" 50\n"
                     "Film \"image\" \"integer xresolution\" 24 \"integer yresolution\" 20 "
                     "\"string precision\" \"float\"\n"
                     "Sampler \"stratified\" \"integer xsamples\" 1 \"integer ysamples\" 1 \"bool "
                     "jitter\" \"false\"\n"
                     "GlobalIntegrator {} \"float radius\" .15 \"bool directvolume\" "
                     "\"false\"\nWorldBegin\n{}\nWorldEnd\n",
                     method, kPoint + medium))
          .image;
    };
    const LayeredImage pvpm =
        render(fmt::format("\"pvpm\" \"integer passes\" 1 \"integer photonsperpass\" 4000 \"bool "
                           "fixedbeams\" \"true\" "
                           "\"string savephotons\" \"{}\"",
                           file));
    const LayeredImage bre = render(fmt::format("\"bre\" \"string loadphotons\" \"{}\"", file));
    double sum = 0;
    for (const char* c : {"R", "G", "B"})
      for (std::size_t i = 0; i < pvpm.channels.at(c).size(); ++i) {
        sum += double{pvpm.channels.at(c)[i]};
        EXPECT_NEAR(pvpm.channels.at(c)[i], bre.channels.at(c)[i], 1e-5f * bre.channels.at(c)[i])
            << c << i << medium;
      }
    EXPECT_GT(sum, 0);
  }
  std::remove(file.c_str());
}

TEST(Pvpm, RadiiOfSinglePixelsConvergeToTheSameImage) {
  // 32 passes of each schedule from the same first radius: equal but for noise and what is left of
  // the bias, 5 % of a blurred image.
  const auto mean = [&](const std::string& schedule) {
    return meanOverSeeds(
        scene("\"pvpm\" \"integer passes\" 32 \"integer photonsperpass\" 4000 \"float radius\" .2 "
              "\"string schedule\" \"" +
                  schedule + "\"",
              kPoint + kFog, 8, "0 0 -4 0 0 0 0 1 0", 6),
        6);
  };
  const Estimate global = mean("global"), beam = mean("beam");
  EXPECT_NEAR(beam.mean, global.mean,
              0.05 * global.mean + 4 * std::hypot(global.standardError, beam.standardError));
  EXPECT_LT(beam.standardError, 0.02 * beam.mean);
}

TEST(Pvpm, LoadedPhotonsGiveTheSavedImage) {
  const std::string file = testing::TempDir() + fmt::format("brume_pvpm_{}.photons", ::getpid());
  const auto render = [&](const std::string& what) {
    return renderText(
               scene(fmt::format("\"pvpm\" \"integer passes\" 1 \"integer photonsperpass\" 2000 "
                                 "\"float radius\" .1 \"string {}photons\" \"{}\"",
                                 what, file),
                     kPoint + kFog))
        .image;
  };
  const LayeredImage saved = render("save"), loaded = render("load");
  expectSameImages(saved, loaded);
  std::remove(file.c_str());
}

TEST(Pvpm, SamplesPerPixelArePasses) {
  const std::string text =
      scene("\"pvpm\" \"integer passes\" 9 \"integer photonsperpass\" 100", kPoint + kFog);
  const auto passesOf = [&](const RenderSettings& settings) {
    return renderText(text, settings).passes;
  };
  RenderSettings settings;
  EXPECT_EQ(passesOf(settings), 9);
  settings.samplesPerPixel = 2;
  EXPECT_EQ(passesOf(settings), 2);
  settings.passes = 3;
  EXPECT_EQ(passesOf(settings), 6);
  settings.samplesPerPixel.reset();
  EXPECT_EQ(passesOf(settings), 3);
}

TEST(Pvpm, ThePlanCountsBeams) {
  // From z = -4 the box's front face, at distance 3, fills the middle of 2 tan(45) 3 = 6: a third
  // of the width and height, up to the pixels on its border.
  const auto job = makeJob(scene("\"pvpm\"", kPoint + kFog, 60, "0 0 -4 0 0 0 0 1 0", 90), {},
                           test::captureLog());
  const std::vector<std::string> plan = job->plan();
  EXPECT_THAT(plan, testing::Contains(testing::HasSubstr("about 400 of 3600 pixels")));
  EXPECT_THAT(plan, testing::Contains(testing::HasSubstr("skip  caustic photons")));
}

TEST(Pvpm, SceneWithoutMediaHasNoBeams) {
  const RenderResult result =
      renderText(scene("\"pvpm\" \"integer passes\" 2 \"integer photonsperpass\" 1000",
                       kPoint + "Material \"matte\" Shape \"sphere\""));
  EXPECT_EQ(result.stats[Stat::PhotonBeamPairs], 0u);
  EXPECT_GT(meanOf(result.image).g, 0);
}

TEST(Pvpm, SceneWithNothingForPhotonsTracesNone) {
  const RenderResult result =
      renderText(scene("\"pvpm\" \"integer passes\" 2",
                       "LightSource \"infinite\" Material \"mirror\" Shape \"sphere\""));
  EXPECT_EQ(result.stats[Stat::PhotonPaths], 0u);
  EXPECT_GT(meanOf(result.image).g, 0.5f);
}

TEST(Pvpm, MirrorsShowTheFogBehind) {
  // A mirror in front of the camera shows the fog behind it: secondary beams.
  const std::string world = kPoint + kFog +
                            "Material \"mirror\" \"color Kr\" [1 1 1] Translate 0 0 -6 Shape "
                            "\"disk\" \"float radius\" 9 ";
  const std::string look = "0 0 -4 0 0 -8 0 1 0";
  const Estimate truth = meanOverSeeds(scene("\"volpath\"", world, 8, look, 4, 64), 12);
  const Estimate pvpm = meanOverSeeds(
      scene("\"pvpm\" \"integer passes\" 4 \"integer photonsperpass\" 4000 \"float radius\" .05",
            world, 8, look, 4),
      12);
  // The mirror also lights the fog: caustic photons, which volpath cannot find; it is darker.
  EXPECT_GT(pvpm.mean, truth.mean - 4 * truth.standardError);
  EXPECT_LT(pvpm.mean, 1.5 * truth.mean);
}

TEST(Pvpm, BeamsMeetPhotonsOfTheirOwnTime) {
  // A card moves through the fog from the lamp past the camera: while it is between the two, the
  // camera sees fog in its shadow, which photons of other times would light.
  const std::string card =
      "AttributeBegin Material \"matte\" \"color Kd\" [0 0 0] "
      "ActiveTransform StartTime Translate 0 0 .5 ActiveTransform EndTime Translate 0 0 -6 "
      "ActiveTransform All "
      "Shape \"disk\" \"float radius\" 40 AttributeEnd ";
  const std::string world =
      "LightSource \"point\" \"point from\" [0 0 2] " + fog("\"color sigma_s\" [1 1 1]") + card;
  const auto render = [&](const std::string& integrator) {
    return meanOverSeeds(scene(integrator, world, 8, "0 0 -4 0 0 0 0 1 0", 10, 16), 8);
  };
  const Estimate truth = render("\"volpath\"");
  const Estimate pvpm = render(
      "\"pvpm\" \"integer passes\" 16 \"integer photonsperpass\" 2000 \"float radius\" .1 \"bool "
      "directvolume\" \"false\"");
  EXPECT_NEAR(pvpm.mean, truth.mean,
              4 * std::hypot(pvpm.standardError, truth.standardError) + 0.03 * truth.mean);
}

/// Footprints are those of the samples per pixel, whatever a pass takes. The mean of "wrinkled"
/// grows with the octaves that a footprint lets through.
TEST(Pvpm, TexturesAreFilteredAsByOthers) {
  const std::string world =
      "LightSource \"distant\" \"point from\" [0 0 -1] \"point to\" [0 0 0] "
      "Texture \"n\" \"float\" \"wrinkled\" \"integer octaves\" 8 "
      "Texture \"t\" \"color\" \"mix\" \"texture amount\" \"n\" \"color tex1\" [.7 .7 .7] "
      "\"color tex2\" [.1 .1 .1] "
      "Material \"matte\" \"texture Kd\" \"t\" Shape \"disk\" \"float radius\" 4 ";
  RenderSettings rounds;
  rounds.passes = 256;
  const auto render = [&](const std::string& integrator, int samples,
                          const RenderSettings& settings) {
    return meanOf(renderText(scene(integrator, world, 8, kAhead, 30, samples), settings).image).g;
  };
  const float others = render("\"volpath\"", 256, {}),
              pvpm = render("\"pvpm\" \"integer photonsperpass\" 10", 256, rounds),
              wholePixels = render("\"volpath\"", 1, rounds);
  EXPECT_NEAR(pvpm, others, 0.005f * others);  // noise of the positions in the pixels
  EXPECT_GT(std::abs(wholePixels - others), 0.05f * others);
}

TEST(Pvpm, AWhiteFurnaceIsWhite) {
  // Albedo 1 under radiance 1: the middle of the image is 1 but for noise.
  const Estimate e = meanOverSeeds(
      scene("\"pvpm\" \"integer passes\" 4 \"integer photonsperpass\" 16000 \"float radius\" .05 "
            "\"bool directvolume\" "
            "\"false\"",
            "LightSource \"infinite\" " + fog("\"color sigma_s\" [1 1 1] \"float g\" .6"), 8,
            "0 0 -4 0 0 0 0 1 0", 6),
      12);
  EXPECT_LT(std::abs(e.z(1)), 4) << e.mean;
  EXPECT_LT(e.standardError, 0.02);
}

}  // namespace
}  // namespace brume
