// SPDX-License-Identifier: Apache-2.0
// What a scene does not need is not done: the plan says so, and the counters of the skipped work
// are zero.
#include "core/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "core/medium_along_ray.h"
#include "support/render_text.h"
#include "support/run_program.h"
#include "support/volumes.h"
#include "tools/child_process.h"

namespace brume {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kOptions = R"(
Film "image" "integer xresolution" 16 "integer yresolution" 16
Sampler "random" "integer pixelsamples" 4
VolumeIntegrator "single"
LookAt 0 0 -5  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
)";
const std::string kBall = "Material \"matte\"\nShape \"sphere\"\n";
const std::string kLamp = "LightSource \"point\" \"point from\" [0 4 -4] \"color I\" [9 9 9]\n";

struct Rendered {
  std::vector<std::string> plan;
  RenderResult result;
  std::uint64_t operator[](Stat stat) const { return result.stats[stat]; }
};
Rendered render(const std::string& options, const std::string& world) {
  Log log({Verbosity::Normal, false, true});
  const auto job = makeJob(options + world + "WorldEnd\n", {}, log);
  const std::atomic<bool> stop{false};
  Rendered rendered;
  rendered.result = job->run(stop, {});
  rendered.plan = job->plan();
  EXPECT_TRUE(log.captured().empty()) << log.captured().front();
  return rendered;
}
Rendered render(const std::string& world) { return render(kOptions, world); }

TEST(Plan, TexturesThatNoSurfaceUsesAreNotLoaded) {
  // The image is not there: loading it would be an error.
  const Rendered r =
      render(kLamp +
             "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"none.exr\"\n"
             "MakeNamedMaterial \"m\" \"string type\" \"matte\" \"texture Kd\" \"t\"\n" +
             kBall);
  EXPECT_THAT(r.plan, Contains("skip  1 texture: used by no surface, so not loaded"));
  EXPECT_THAT(r.plan, Contains("skip  1 material: used by no surface"));
  EXPECT_THAT(r.plan, Contains(HasSubstr("skip  ray footprints")));
}

/// A folder with an image that takes 64 MiB of memory, and a measured BRDF.
class PlanOfFiles : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::TemporaryFolder;
    RgbImage image(2048, 2048);
    for (Rgb& pixel : image.pixels) pixel = Rgb(.5f);
    writeImage(path("wide.exr"), image);
    std::string merl(12 + std::size_t{90} * 90 * 180 * 24, '\0');
    const std::int32_t dims[] = {90, 90, 180};
    std::memcpy(merl.data(), dims, sizeof dims);
    folder_->write("black.binary", merl);
  }
  static void TearDownTestSuite() { delete folder_; }
  static std::string path(const std::string& name) { return (folder_->path() / name).string(); }
  /// A disk of each material, and a ball.
  static std::string world(const std::string& place) {
    return kLamp + kBall + "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"" +
           path("wide.exr") + "\"\nMaterial \"matte\" \"texture Kd\" \"t\"\n" + place +
           "Shape \"disk\" \"float radius\" .1\nMaterial \"measured\" \"string filename\" \"" +
           path("black.binary") + "\"\nTranslate .3 0 0 Shape \"disk\" \"float radius\" .1\n";
  }

 private:
  static inline test::TemporaryFolder* folder_ = nullptr;
};

TEST_F(PlanOfFiles, TexturesAndMaterialsThatNoRayMeetsAreNotRead) {
  Log log({Verbosity::Normal, false, true});
  const auto job = makeJob(kOptions + world("Translate 0 0 -9 ") + "WorldEnd\n", {}, log);
  const std::string all = " 2 files of textures and materials: ";
  EXPECT_THAT(job->plan(),
              Contains("build" + all + "read when a ray first meets them, 80.7 MiB if it does"));
  const std::atomic<bool> stop{false};
  const RenderResult behind = job->run(stop, {});
  EXPECT_EQ(job->files().read, 0u);
  EXPECT_EQ(job->files().unread, 2u);
  EXPECT_THAT(job->plan(), Contains("skip " + all + "no ray met them, 80.7 MiB are not taken"));
  EXPECT_THAT(behind.image.metadata.at("brume:plan"), HasSubstr("no ray met them"));

  // In view both are read, and by nothing else.
  const auto seen = makeJob(kOptions + world("Translate -.8 1.3 -1 ") + "WorldEnd\n", {}, log);
  EXPECT_EQ(seen->files().read, 0u);
  const RenderResult result = seen->run(stop, {});
  EXPECT_EQ(seen->files().read, 2u);
  EXPECT_EQ(seen->files().unread, 0u);
  EXPECT_THAT(seen->plan(), Contains("build" + all + "read"));
  EXPECT_NE(result.image.channels.at("R"), behind.image.channels.at("R"));
}

TEST_F(PlanOfFiles, ReadingLateChangesNoPixel) {
  const std::string text = kOptions + world("Translate -.8 1.3 -1 ") + "WorldEnd\n";
  Log log({Verbosity::Normal, false, true});
  const std::atomic<bool> stop{false};
  const auto late = makeJob(text, {}, log), early = makeJob(text, {}, log);
  early->readAllFiles();
  EXPECT_EQ(early->files().read, 2u);
  EXPECT_EQ(early->run(stop, {}).image.channels, late->run(stop, {}).image.channels);
}

TEST_F(PlanOfFiles, NotReadingTakesNoLongerThanReading) {
  const std::string text = kOptions + world("Translate 0 0 -9 ") + "WorldEnd\n";
  Log log({Verbosity::Normal, false, true});
  const std::atomic<bool> stop{false};
  const auto timeOf = [&](bool readsAll) {
    const double begin = processorSeconds();
    const auto job = makeJob(text, {}, log);
    if (readsAll) job->readAllFiles();
    job->run(stop, {});
    return processorSeconds() - begin;
  };
  // The render takes some 10 ms, the files some 500.
  EXPECT_LT(5 * timeOf(false), timeOf(true));
}

TEST(Plan, ObjectsThatAreNotInstancedAreNotBuilt) {
  const Rendered r =
      render(kLamp + kBall + "ObjectBegin \"o\"\nShape \"cylinder\"\nShape \"disk\"\nObjectEnd\n");
  EXPECT_THAT(r.plan, Contains("skip  1 object: defined and never instanced"));
  EXPECT_THAT(r.plan, Contains(HasSubstr("0 triangles, 1 quadric, 0 instances of 0 objects")));
}

TEST(Plan, BlackLightsAreNotSampled) {
  const Rendered r = render("LightSource \"point\" \"color I\" [0 0 0]\n" + kBall);
  EXPECT_THAT(r.plan, Contains("skip  1 light: emitting nothing"));
  EXPECT_THAT(r.plan, Contains("skip  lights: the scene has none that lights it"));
  EXPECT_EQ(r[Stat::ShadowRays], 0u);
}

TEST(Plan, EvenSkiesAreNotLookedAt) {
  const std::string sky = "LightSource \"infinite\"\n",
                    fog = "Volume \"homogeneous\" \"color sigma_s\" [2 2 2]\n";
  const auto found =
      Contains("skip  looking at the sky: it is about even: the rays that go on find it as well");
  for (const std::string integrator :
       {"SurfaceIntegrator \"path\"\nVolumeIntegrator \"emission\"\n",
        "GlobalIntegrator \"volpath\"\n"}) {
    const std::string options = integrator + kOptions.substr(0, kOptions.find("VolumeIntegrator")) +
                                kOptions.substr(kOptions.find("LookAt"));
    const Rendered even = render(options, sky + fog + kBall),
                   with = render(options, sky + kLamp + fog + kBall);
    EXPECT_THAT(even.plan, found) << integrator;
    EXPECT_THAT(with.plan, found) << integrator;
    EXPECT_EQ(even[Stat::ShadowRays], 0u) << integrator;
    EXPECT_GT(with[Stat::ShadowRays], 100u) << integrator;
    EXPECT_THAT(render(options, kLamp + fog + kBall).plan, Not(found)) << integrator;
  }
}

TEST(Plan, LightsThatCannotReachTheSceneAreNotSampled) {
  // It shines away from the ball; the other one lights it.
  const std::string away =
      "LightSource \"spot\" \"point from\" [0 9 0] \"point to\" [0 99 0] \"color I\" [9 9 9]\n";
  const Rendered alone = render(away + kBall);
  EXPECT_THAT(alone.plan, Contains("skip  1 light: shining past all surfaces and media"));
  EXPECT_EQ(alone[Stat::ShadowRays], 0u);
  const Rendered both = render(away + kLamp + kBall), lamp = render(kLamp + kBall);
  EXPECT_THAT(both.plan, Contains(HasSubstr("build lights: 1 without extent")));
  EXPECT_EQ(both[Stat::ShadowRays], lamp[Stat::ShadowRays]);
  EXPECT_EQ(both.result.image.channels.at("R"), lamp.result.image.channels.at("R"));
}

TEST(Plan, LightsWithoutPositionAreKept) {
  for (const char* light : {"LightSource \"infinite\"\n", "LightSource \"distant\"\n"}) {
    const Rendered r = render(light + kBall);
    EXPECT_GT(r[Stat::ShadowRays], 0u) << light;
    EXPECT_GT(meanOf(r.result.image).r, 0) << light;
  }
}

TEST(Plan, LightsThatReachAMediumOnlyAreKept) {
  const Rendered r = render(
      "LightSource \"spot\" \"point from\" [0 9 0] \"point to\" [0 99 0] \"color I\" [9 9 9]\n"
      "Volume \"homogeneous\" \"point p0\" [-1 10 -1] \"point p1\" [1 12 1] \"color sigma_s\" [1 1 "
      "1]\n" +
      kBall);
  EXPECT_THAT(r.plan, Contains(HasSubstr("build lights: 1 without extent")));
}

TEST(Plan, PixelsWithoutMediumCostNothing) {
  const std::string fog =
      "Volume \"homogeneous\" \"point p0\" [A -9 -1] \"point p1\" [9 9 1] \"color sigma_s\" [.1 .1 "
      ".1]\n";
  const auto fogFrom = [&](const std::string& x) {
    std::string text = fog;
    return text.replace(text.find('A'), 1, x);
  };
  const Rendered none = render(kLamp + fogFrom("8")), half = render(kLamp + fogFrom("0")),
                 all = render(kLamp + fogFrom("-9"));
  EXPECT_EQ(none[Stat::VolumeSegments], 0u);
  EXPECT_EQ(none[Stat::VolumeSamples], 0u);
  EXPECT_EQ(none[Stat::ShadowRays], 0u);
  EXPECT_EQ(all[Stat::VolumeSegments], all[Stat::CameraRays]);
  // Half of the image, give or take the perspective of a box that is 2 deep: within a pixel column.
  EXPECT_NEAR(double(half[Stat::VolumeSegments]), double(half[Stat::CameraRays]) / 2,
              double(half[Stat::CameraRays]) / 8);
}

TEST(Plan, EmptySpaceInGridsIsSteppedOver) {
  constexpr int kSide = 32;
  test::MediumSpec spec;
  spec.sigma_s = Rgb(1);
  std::vector<float> density(kSide * kSide * kSide, 1.f);
  const auto spansOf = [&](const Vec3& through) {
    const auto grid = test::makeGrid(spec, kSide, kSide, kSide, density);
    const Ray ray{through - Vec3(2, 0, 0), Vec3(1, 0, 0)};
    const MediumAlongRay medium(*grid, ray, *grid->intersect(ray));
    return std::vector<MediumAlongRay::Span>(medium.spans().begin(), medium.spans().end());
  };
  const Vec3 middle(16.5f / kSide);
  EXPECT_GE(spansOf(middle).size(), kSide - 1u);
  // One voxel is left: along the ray the two cells beside it, none elsewhere.
  std::fill(density.begin(), density.end(), 0.f);
  density[(16 * kSide + 16) * kSide + 16] = 1;
  const auto spans = spansOf(middle);
  EXPECT_GE(spans.size(), 1u);
  EXPECT_LE(spans.size(), 2u);
  EXPECT_LE(spans.back().t1 - spans.front().t0, 2.01 / kSide);
  EXPECT_TRUE(spansOf(Vec3(8.f / kSide)).empty());
}

TEST(Plan, MediaThatDoNothingAreNotThere) {
  const std::string clear = "Volume \"homogeneous\" \"point p0\" [-1 -1 -1] \"point p1\" [1 1 1]\n";
  const std::string empty =
      "Volume \"volumegrid\" \"integer nx\" 2 \"integer ny\" 1 \"integer nz\" 1 \"float density\" "
      "[0 0]\n"
      "  \"color sigma_s\" [1 1 1]\n";
  const Rendered r = render(kLamp + clear + empty + kBall), plain = render(kLamp + kBall);
  EXPECT_THAT(r.plan, Contains("skip  2 volumes: neither absorbing, scattering nor emitting"));
  EXPECT_THAT(r.plan, Contains(HasSubstr("skip  volume integrator \"single\"")));
  EXPECT_EQ(r[Stat::VolumeSegments], 0u);
  EXPECT_EQ(r.result.image.channels.at("G"), plain.result.image.channels.at("G"));
}

/// The same view by one of the photon methods.
Rendered renderBy(const std::string& integrator, const std::string& world) {
  std::string options = kOptions;
  options.replace(options.find("VolumeIntegrator"), 0, integrator + "\n");
  return render(options, world);
}
// With its radii given, no pilot pass looks for them.
const std::string kPvpm =
    "GlobalIntegrator \"pvpm\" \"integer photonsperpass\" 500 \"integer passes\" 2 "
    "\"float radius\" .2 \"float surfaceradius\" .2";
const std::string kFog =
    "Volume \"homogeneous\" \"point p0\" [-2 -2 -2] \"point p1\" [2 2 2] \"color sigma_s\" [.3 .3 "
    ".3]\n";
const std::string kGlass =
    "Material \"glass\"\nTranslate 0 2 0 Shape \"sphere\" \"float radius\" .5\n";

TEST(Plan, NoCausticPhotonsWithoutSpecularSurfaces) {
  const std::string photonmap =
      "SurfaceIntegrator \"photonmap\" \"integer causticphotons\" 200 \"integer indirectphotons\" "
      "0";
  const Rendered matte = renderBy(photonmap, kLamp + kBall);
  EXPECT_THAT(matte.plan, Contains("skip  caustic photon map: no surface is specular"));
  EXPECT_EQ(matte[Stat::PhotonPaths], 0u);
  EXPECT_EQ(matte[Stat::PhotonsStored], 0u);
  const Rendered glass = renderBy(photonmap, kLamp + kBall + kGlass);
  EXPECT_THAT(glass.plan, Contains(HasSubstr("build caustic photon map")));
  EXPECT_GE(glass[Stat::PhotonsStored], 200u);
  EXPECT_THAT(renderBy(kPvpm, kLamp + kBall).plan,
              Contains("skip  caustic photons: no surface is specular"));
}

TEST(Plan, MapsOfPhotonsAreBuiltForWhatShowsThem) {
  const auto planOf = [](const std::string& params, const std::string& world) {
    return renderBy("GlobalIntegrator \"bre\" \"integer photons\" 100 " + params, world).plan;
  };
  const auto inFog = planOf("\"integer surfacephotons\" 200", kLamp + kBall + kFog);
  EXPECT_THAT(inFog, Contains("build map of photons in media: about 100 of them"));
  EXPECT_THAT(inFog, Contains("build map of photons on surfaces: about 200 of them"));
  EXPECT_THAT(inFog, Contains("skip  caustic photons: no surface is specular"));
  const auto clear = planOf("\"integer surfacephotons\" 0", kLamp + kBall + kGlass);
  EXPECT_THAT(clear, Contains("skip  map of photons in media: no medium scatters"));
  EXPECT_THAT(clear, Contains("skip  map of photons on surfaces: none are asked for"));
  EXPECT_THAT(clear, testing::Not(Contains(HasSubstr("caustic"))));
}

TEST(Plan, NoBeamsWithoutScatteringMedium) {
  const std::string smoke =
      "Volume \"homogeneous\" \"point p0\" [-2 -2 -2] \"point p1\" [2 2 2] \"color sigma_a\" [.3 "
      ".3 "
      ".3]\n";
  const Rendered r = renderBy(kPvpm, kLamp + smoke + kBall);
  EXPECT_THAT(r.plan, Contains("skip  camera beams and photons in media: no medium scatters"));
  EXPECT_EQ(r[Stat::PhotonBeamPairs], 0u);
  EXPECT_EQ(r[Stat::VolumeSamples], 0u);
  EXPECT_GT(renderBy(kPvpm, kLamp + kFog + kBall)[Stat::PhotonBeamPairs], 0u);
}

TEST(Plan, NoPhotonsOnSurfacesWhereNothingIsDiffuse) {
  const Rendered r = renderBy(kPvpm, kLamp + kFog + "Material \"mirror\"\nShape \"sphere\"\n");
  EXPECT_THAT(r.plan, Contains("skip  visible points and photons on surfaces: nothing in the "
                               "scene is diffuse"));
  // All that is stored lies in the medium: without it, nothing is.
  const Rendered clear = renderBy(kPvpm, kLamp + "Material \"mirror\"\nShape \"sphere\"\n");
  EXPECT_EQ(clear[Stat::PhotonsStored], 0u);
  EXPECT_EQ(clear[Stat::PhotonPaths], 0u);
  EXPECT_GT(r[Stat::PhotonsStored], 0u);
}

TEST(Plan, PixelsWithoutMediumHaveNoBeam) {
  const auto fogFrom = [](const char* x) {
    return std::string("Volume \"homogeneous\" \"point p0\" [") + x +
           " -9 -1] \"point p1\" [9 9 1] \"color sigma_s\" [.1 .1 .1]\n";
  };
  const Rendered half = renderBy(kPvpm, kLamp + fogFrom("0")),
                 all = renderBy(kPvpm, kLamp + fogFrom("-9"));
  EXPECT_EQ(all[Stat::VolumeSegments], all[Stat::CameraRays]);
  EXPECT_NEAR(double(half[Stat::VolumeSegments]), double(half[Stat::CameraRays]) / 2,
              double(half[Stat::CameraRays]) / 8);
}

}  // namespace
}  // namespace brume
