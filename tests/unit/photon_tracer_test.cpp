// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_tracer.h"

#include <gmock/gmock.h>

#include <cstring>
#include <mutex>

#include "core/bsdf.h"
#include "core/parallel.h"
#include "renderers/render_job.h"
#include "support/estimate.h"
#include "support/make_plugin.h"
#include "support/render_text.h"
#include "transport/photon_quota.h"

namespace brume {
namespace {

constexpr double kMaxZ = 4;  // fails by chance once in 16,000
const std::atomic<bool> kGoOn{false};

std::unique_ptr<RenderJob> sceneOf(const std::string& world) {
  return makeJob(
      "LookAt 0 0 0 0 0 1 0 1 0 Camera \"perspective\" WorldBegin " + world + " WorldEnd", {},
      test::captureLog());
}

PhotonSet tracePaths(const Scene& scene, PhotonRequest request, std::uint64_t paths,
                     Stats* stats = nullptr, std::uint64_t seed = 1) {
  PathsPerClass perClass{};
  for (std::size_t c = 0; c < kPhotonClasses; ++c)
    if (request.wanted.contains(static_cast<PhotonClass>(c))) perClass[c] = paths;
  Stats own;
  return PhotonTracer(scene, request).trace(seed, 0, perClass, kGoOn, stats ? *stats : own);
}

/// Total power of one channel, photons of one class; the standard error from batches of passes.
Estimate totalPower(const Scene& scene, PhotonRequest request, PhotonClass c, int channel,
                    std::uint64_t paths) {
  constexpr int kBatches = 16;
  double sum = 0, squares = 0;
  for (int i = 0; i < kBatches; ++i) {
    double total = 0;
    for (const Photon& p :
         tracePaths(scene, request, paths, nullptr, static_cast<std::uint64_t>(i)).photons)
      if (p.photonClass() == c) total += double{p.power[channel]};
    sum += total;
    squares += total * total;
  }
  const double mean = sum / kBatches;
  return {mean, std::sqrt(std::max(0.0, squares / kBatches - mean * mean) / (kBatches - 1)) +
                    1e-5 * mean};  // sums of floats where nothing is random
}

const std::string
    kFogBall =  // a light in the middle of a box that no photon gets out of unabsorbed
    "LightSource \"point\" \"point from\" [0 0 5] \"color I\" [1 2 4] ";
std::string box(const std::string& coefficients, float half) {
  return "Volume \"homogeneous\" " + coefficients + " \"point p0\" [" + std::to_string(-half) +
         " " + std::to_string(-half) + " " + std::to_string(5 - half) + "] \"point p1\" [" +
         std::to_string(half) + " " + std::to_string(half) + " " + std::to_string(5 + half) + "] ";
}

TEST(Photon, PacksDirectionsAndNormals) {
  Rng rng(1);
  for (int i = 0; i < 10'000; ++i) {
    const Vec3 w = sampleUniformSphere(rng.uniform2()), n = sampleUniformSphere(rng.uniform2());
    const Photon p = Photon::onSurface(Vec3(1), w, n, Rgb(2), PhotonClass::SurfaceCaustic);
    EXPECT_LT(distance(p.wi.unpack(), w), 7e-5f);
    EXPECT_LT(distance(p.normal(), n), 1e-3f);
    EXPECT_EQ(p.photonClass(), PhotonClass::SurfaceCaustic);
  }
  for (int axis = 0; axis < 3; ++axis)
    for (float sign : {-1.f, 1.f}) {
      Vec3 w(0);
      w[axis] = sign;
      EXPECT_EQ(PackedDirection(w).unpack(), w);
    }
}

TEST(PhotonTracer, AbsorbingMediumTakesAllPower) {
  // Optical thickness 40 on all sides, nothing scatters: every photon is stored once, and the
  // deposits hold the power 4 pi I of the light.
  const auto job = sceneOf(kFogBall + box("\"color sigma_a\" [20 20 20]", 2));
  const PhotonRequest request{kVolumePhotons};
  for (int channel : {0, 1, 2}) {
    const Estimate e =
        totalPower(job->scene(), request, PhotonClass::VolumeUnscattered, channel, 2000);
    EXPECT_NEAR(e.mean, 4 * M_PI * (1 << channel), 1e-4 * e.mean);
  }
  EXPECT_EQ(tracePaths(job->scene(), request, 1000).photons.size(), 1000u);
}

TEST(PhotonTracer, DepositsAreExtinctionTimesFluence) {
  // By energy balance the absorbed part of all deposits is the emitted power where none escapes:
  // sum over classes = P / (1 - albedo), of which P are unscattered. Chromatic: a channel's albedo
  // and extinction are its own.
  const auto job = sceneOf(
      kFogBall + box("\"color sigma_a\" [4 10 8] \"color sigma_s\" [16 10 2] \"float g\" .5", 3));
  const PhotonRequest request{kVolumePhotons};
  const double albedo[3] = {.8, .5, .2};
  for (int channel : {0, 1, 2}) {
    const double power = 4 * M_PI * (1 << channel);
    const Estimate direct =
        totalPower(job->scene(), request, PhotonClass::VolumeUnscattered, channel, 4000);
    const Estimate multiple =
        totalPower(job->scene(), request, PhotonClass::VolumeMultiple, channel, 4000);
    EXPECT_LT(std::abs(direct.z(power)), kMaxZ) << channel << " mean " << direct.mean;
    EXPECT_LT(std::abs(multiple.z(power * albedo[channel] / (1 - albedo[channel]))), kMaxZ)
        << channel << " mean " << multiple.mean;
    EXPECT_LT(multiple.standardError, 0.02 * multiple.mean);
  }
}

TEST(PhotonTracer, ClosedRoomKeepsItsLedger) {
  // A matte sphere of reflectance 1/2 around the light: direct P, indirect P/2 + P/4 + ... = P.
  const auto job = sceneOf(
      "LightSource \"point\" \"point from\" [0 0 5] Material \"matte\" \"color Kd\" [.5 .5 .5] "
      "Translate 0 0 5 Shape \"sphere\" \"float radius\" 3");
  const PhotonRequest request{kSurfacePhotons};
  const Estimate direct = totalPower(job->scene(), request, PhotonClass::SurfaceDirect, 0, 4000);
  const Estimate indirect =
      totalPower(job->scene(), request, PhotonClass::SurfaceIndirect, 0, 4000);
  EXPECT_NEAR(direct.mean, 4 * M_PI, 1e-3);
  EXPECT_LT(std::abs(indirect.z(4 * M_PI)), kMaxZ) << indirect.mean;
}

TEST(PhotonTracer, GlassKeepsPowerAndMakesCaustics) {
  // A light inside a glass sphere that is inside a black room: what leaves is caustic light;
  // nothing is lost but what stays inside by total reflection (none from the centre).
  const auto job = sceneOf(
      "LightSource \"point\" \"point from\" [0 0 5] Translate 0 0 5 Material \"glass\" "
      "Shape \"sphere\" \"float radius\" 1 Material \"matte\" \"color Kd\" [.5 .5 .5] "
      "Shape \"sphere\" \"float radius\" 3");
  const PhotonRequest request{kSurfacePhotons};
  const Estimate caustic = totalPower(job->scene(), request, PhotonClass::SurfaceCaustic, 0, 4000);
  // The light is inside glass: the power that leaves is scaled by eta^2 (radiance is not).
  EXPECT_LT(std::abs(caustic.z(4 * M_PI * 1.5 * 1.5)), kMaxZ) << caustic.mean;
  EXPECT_EQ(totalPower(job->scene(), request, PhotonClass::SurfaceDirect, 0, 500).mean, 0);
}

TEST(PhotonTracer, StoresOnlyWhatIsWanted) {
  const auto job = sceneOf(kFogBall + box("\"color sigma_s\" [2 2 2]", 2));
  Stats all, direct;
  tracePaths(job->scene(), {kVolumePhotons}, 1000, &all);
  const auto set = tracePaths(job->scene(), {PhotonClass::VolumeUnscattered}, 1000, &direct);
  for (const Photon& p : set.photons) EXPECT_EQ(p.photonClass(), PhotonClass::VolumeUnscattered);
  // A path ends with its first collision.
  EXPECT_EQ(direct[Stat::PhotonSegments], 1000u);
  EXPECT_GT(all[Stat::PhotonSegments], 4000u);
}

TEST(PhotonTracer, ThreadsDoNotMatter) {
  const auto job =
      sceneOf(kFogBall + box("\"color sigma_s\" [2 1 2] \"color sigma_a\" [0 .1 0]", 2));
  std::vector<Photon> first;
  for (int threads : {1, 2, 7}) {
    setThreadCount(threads);
    const auto photons = tracePaths(job->scene(), {kVolumePhotons}, 10'000).photons;
    if (first.empty()) first = photons;
    ASSERT_EQ(photons.size(), first.size());
    EXPECT_EQ(std::memcmp(photons.data(), first.data(), first.size() * sizeof(Photon)), 0);
  }
  setThreadCount(0);
}

TEST(PhotonTracer, PhotonsComeInTheOrderOfTheirPaths) {
  // Those of the first paths do not depend on how many there are. A floor and fog: classes mix.
  const auto job = sceneOf(kFogBall + box("\"color sigma_s\" [2 1 2]", 1) +
                           "Material \"matte\" Translate 0 -1.5 5 Rotate 90 1 0 0 Shape \"disk\" "
                           "\"float radius\" 9 ");
  const PhotonRequest request{kVolumePhotons | kSurfacePhotons};
  const auto few = tracePaths(job->scene(), request, 333).photons,
             many = tracePaths(job->scene(), request, 3000).photons;
  ASSERT_GT(few.size(), 1000u);
  ASSERT_GT(many.size(), few.size());
  for (std::size_t i = 0; i < few.size(); ++i) {
    ASSERT_EQ(few[i].p, many[i].p);
    ASSERT_EQ(few[i].wi.bits(), many[i].wi.bits());
  }
}

TEST(PhotonTracer, SurfacesThatCannotBeMetAreNotAskedFor) {
  // A small ball in fog, and nothing but fog: the photons are those of a tracer that always asks.
  for (const std::string ball : {"Translate .3 .2 5 Shape \"sphere\" \"float radius\" .2 ", ""})
    for (const std::string sigma : {"[2 2 2]", "[1 2 4]"}) {
      const auto job =
          sceneOf(kFogBall + box("\"color sigma_s\" " + sigma, 1) + "Material \"matte\" " + ball);
      PhotonRequest request{kVolumePhotons | kSurfacePhotons};
      Stats some, all;
      const auto seldom = tracePaths(job->scene(), request, 5000, &some).photons;
      request.looksEverywhere = true;
      const auto always = tracePaths(job->scene(), request, 5000, &all).photons;
      ASSERT_EQ(seldom.size(), always.size());
      EXPECT_EQ(std::memcmp(seldom.data(), always.data(), always.size() * sizeof(Photon)), 0);
      EXPECT_EQ(all[Stat::IntersectionRays], all[Stat::PhotonSegments]);
      EXPECT_LT(some[Stat::IntersectionRays],
                all[Stat::IntersectionRays] / (ball.empty() ? 1000 : 2));
    }
}

TEST(PhotonTracer, WhiteFurnaceHasTheFluenceOfTheSky) {
  // Radiance 1 from everywhere, albedo 1: fluence 4 pi everywhere, deposits sigma_t 4 pi per
  // volume.
  const auto job = sceneOf("LightSource \"infinite\" " + box("\"color sigma_s\" [.5 1 2]", 1));
  const PhotonRequest request{kVolumePhotons};
  for (int channel : {0, 1, 2}) {
    double mean = 0, variance = 0;
    for (PhotonClass c : {PhotonClass::VolumeUnscattered, PhotonClass::VolumeMultiple}) {
      const Estimate e = totalPower(job->scene(), request, c, channel, 2000);
      mean += e.mean;
      variance += sqr(e.standardError);
    }
    const double expected = 4 * M_PI * 8 * (0.5 * (1 << channel));
    EXPECT_LT(std::abs(mean - expected), kMaxZ * std::sqrt(variance)) << channel << " " << mean;
    EXPECT_LT(std::sqrt(variance), 0.02 * expected);
  }
}

TEST(PhotonTracer, AimingAtSmallMediaChangesNoExpectation) {
  // A small box of thin fog over a large floor, lit from far away: paths are split, and the power
  // of the photons is what Beer-Lambert says.
  const std::string floor =
      "Material \"matte\" \"color Kd\" [0 0 0] Translate 0 -3 5 Rotate 90 1 0 0 Shape \"disk\" "
      "\"float radius\" 60 ";
  for (const std::string light :
       {"LightSource \"distant\" \"point from\" [0 1 0] ",
        "LightSource \"point\" \"point from\" [0 40 5] \"color I\" [1600 1600 1600] ",
        "AttributeBegin AreaLightSource \"area\" \"color L\" [1600 1600 1600] "
        "Translate 0 40 5 Shape \"sphere\" \"float radius\" .5641896 AttributeEnd ",
        "AttributeBegin AreaLightSource \"area\" \"color L\" [1600 1600 1600] "
        "Translate 0 40 5 Rotate 90 1 0 0 Shape \"disk\" \"float radius\" .5641896 AttributeEnd ",
        "LightSource \"spot\" \"point from\" [0 40 5] \"point to\" [0 0 5] "
        "\"float coneangle\" 60 \"color I\" [1600 1600 1600] "}) {
    const auto job = sceneOf(light + box("\"color sigma_a\" [.1 .1 .1]", 1) + floor);
    const Estimate e =
        totalPower(job->scene(), {kVolumePhotons}, PhotonClass::VolumeUnscattered, 0, 80000);
    // Irradiance 1 on a face of 4, of which 1 - exp(-0.2) collides; a point light's rays diverge,
    // and its irradiance falls, by some 0.1 % over the box.
    const double expected = 4 * -std::expm1(-0.2);
    EXPECT_NEAR(e.mean, expected, 4 * e.standardError + 0.003 * expected) << light;
    EXPECT_LT(e.standardError, 0.01 * expected) << light;
  }
}

TEST(PhotonTracer, LightFromVeryFarReachesAllOfTheMedia) {
  // What enters a box of side 2 is absorbed there; it shows the area 4 (|dx| + |dy|).
  const auto job = sceneOf(
      "LightSource \"point\" \"point from\" [3e4 4e4 5] \"color I\" [2.5e9 2.5e9 2.5e9] " +
      box("\"color sigma_a\" [1e5 1e5 1e5]", 1) +
      "Material \"matte\" Translate 0 -3 5 Rotate 90 1 0 0 Shape \"disk\" \"float radius\" 60 ");
  const Estimate e =
      totalPower(job->scene(), {kVolumePhotons}, PhotonClass::VolumeUnscattered, 0, 20000);
  const double expected = 4 * (0.6 + 0.8);
  // Distances to the light differ by 2e-4 of it.
  EXPECT_NEAR(e.mean, expected, 4 * e.standardError + 1e-3 * expected);
}

/// Fluence times sigma_t in a small ball of thin fog above a wide white floor under a distant
/// light: light that the floor sends up.
const std::string kFogOverFloor =
    "LightSource \"distant\" \"point from\" [0 1 0] Volume \"homogeneous\" "
    "\"color sigma_a\" [.01 .01 .01] \"point p0\" [-.5 -.5 4.5] \"point p1\" [.5 .5 5.5] "
    "Material \"matte\" \"color Kd\" [.5 .5 .5] Translate 0 -1 5 Rotate 90 1 0 0 "
    "Shape \"disk\" \"float radius\" ";

TEST(PhotonTracer, PhotonsFromAWideFloorAreManyAndOfMuchTheSamePower) {
  // Floor and shadow: irradiance 1 gives radiosity 1/2, of which a point at height h above the
  // middle of a disk of radius R meets the fluence 2 pi L (1 - cos) = 1 - cos,
  // cos = h / sqrt(h^2 + R^2); the box casts a shadow of sigma_t, 1 %.
  const auto job = sceneOf(kFogOverFloor + "200");
  const PhotonRequest request{{kVolumePhotons}};
  const Estimate e = totalPower(job->scene(), request, PhotonClass::VolumeMultiple, 0, 20000);
  const double expected = 0.01 * (1 - 1 / std::sqrt(1 + 200. * 200));
  EXPECT_NEAR(e.mean, expected, 4 * e.standardError + 0.012 * expected);
  EXPECT_LT(e.standardError, 0.1 * expected);

  const PhotonSet photons = tracePaths(job->scene(), request, 400000);
  double sum = 0, squares = 0;
  for (const Photon& p : photons.photons)
    if (p.photonClass() == PhotonClass::VolumeMultiple) {
      sum += double{p.power.r};
      squares += sqr(double{p.power.r});
    }
  // As many photons of one power would have the same noise.
  EXPECT_GT(sum * sum / squares, 60);
}

/// What the paths of a tracer leave in the media, by 16 passes.
Estimate powerInMedia(const PhotonTracer& tracer, std::uint64_t paths) {
  constexpr int kPasses = 16;
  PathsPerClass perClass{};
  perClass[static_cast<std::size_t>(PhotonClass::VolumeMultiple)] = paths;
  double sum = 0, squares = 0;
  for (std::uint64_t pass = 0; pass < kPasses; ++pass) {
    Stats stats;
    double total = 0;
    for (const Photon& p : tracer.trace(7, pass, perClass, kGoOn, stats).photons)
      total += double{p.power.r};
    sum += total / kPasses;
    squares += sqr(total) / kPasses;
  }
  return {sum, std::sqrt((squares - sum * sum) / (kPasses - 1))};
}

TEST(PhotonTracer, LearntSharesHaveLessNoiseAndTheSameMean) {
  // A lamp beside the fog, and one as strong for the floor far from it.
  const auto job = sceneOf(
      "LightSource \"point\" \"point from\" [0 1.5 5] \"color I\" [1 1 1] "
      "LightSource \"point\" \"point from\" [300 5 5] \"color I\" [1 1 1] " +
      box("\"color sigma_a\" [.2 .2 .2] \"color sigma_s\" [.3 .3 .3]", 1) +
      "Material \"matte\" Translate 0 -3 5 Rotate 90 1 0 0 Shape \"disk\" \"float radius\" 400 ");
  const PhotonRequest request{PhotonClass::SurfaceIndirect | PhotonClass::VolumeMultiple};
  PhotonTracer tracer(job->scene(), request);
  const Estimate before = powerInMedia(tracer, 8000);

  Stats stats;
  const auto square = [](std::span<const Photon> photons) {
    double sum = 0;
    for (const Photon& p : photons)
      if (!p.isOnSurface()) sum += sqr(double{p.power.r});
    return sum;
  };
  const auto shares = tracer.learnShares(7, 99, 20000, square, kGoOn, stats);
  ASSERT_TRUE(shares);
  double sum = 0;
  for (const float share : *shares) {
    EXPECT_GT(share, 0);
    sum += double{share};
  }
  EXPECT_NEAR(sum, 1, 1e-5);
  tracer.setShares(*shares);
  const Estimate after = powerInMedia(tracer, 8000);
  EXPECT_LT(std::abs(after.z(before)), kMaxZ) << before.mean << " " << after.mean;
  EXPECT_LT(after.standardError, 0.8 * before.standardError);

  // Any shares have the same mean.
  std::vector<float> odd(shares->size());
  for (std::size_t i = 0; i < odd.size(); ++i) odd[i] = i % 2 == 0 ? 1.f : 3.f;
  tracer.setShares(odd);
  EXPECT_LT(std::abs(powerInMedia(tracer, 8000).z(before)), kMaxZ);
}

TEST(PhotonTracer, NothingIsLearntFromOneSourceOrNothing) {
  const auto learn = [](const std::string& world, double value) {
    const auto job = sceneOf(world);
    const PhotonTracer tracer(job->scene(), {kSurfacePhotons | kVolumePhotons});
    Stats stats;
    return tracer.learnShares(
        1, 1, 100, [value](std::span<const Photon>) { return value; }, kGoOn, stats);
  };
  const std::string fog = box("\"color sigma_a\" [.2 .2 .2]", 1);
  EXPECT_FALSE(learn(kFogBall + fog, 1));
  EXPECT_FALSE(learn(kFogBall + kFogBall + fog, 0));
  EXPECT_TRUE(learn(kFogBall + kFogBall + fog, 1));
}

TEST(PhotonTracer, EmissiveMediaAreLights) {
  // Le = sigma_a B for B = 1 and albedo 1/2: what is emitted is absorbed but for what leaves the
  // thick box, so deposits (power in = absorbed + scattered) are 4 pi Le V / (1 - albedo), less the
  // leak, about S / 4 sigma_t of the volume: between 0.9 and 1 of it here.
  const auto job = sceneOf(
      box("\"color sigma_a\" [20 20 20] \"color sigma_s\" [20 20 20] \"color Le\" [1 2 3]", 2));
  for (int channel : {0, 1, 2}) {
    const Estimate e =
        totalPower(job->scene(), {kVolumePhotons}, PhotonClass::VolumeMultiple, channel, 2000);
    const double all = 4 * M_PI * (1 + channel) * 64 / 0.5;
    EXPECT_LT(e.mean, all);
    EXPECT_GT(e.mean, 0.9 * all);
  }
}

PhotonCounts countOf(PhotonClass c, std::uint64_t n) {
  PhotonCounts counts{};
  counts[static_cast<std::size_t>(c)] = n;
  return counts;
}

TEST(PhotonQuota, FindsThePathsForACount) {
  const auto job = sceneOf(kFogBall + box("\"color sigma_a\" [.2 .2 .2]", 1));
  const PhotonTracer tracer(job->scene(), {kVolumePhotons});
  Stats stats;
  const auto paths =
      pathsFor(tracer, countOf(PhotonClass::VolumeUnscattered, 20'000), {}, 1, kGoOn, stats);
  const auto stored = tracer.trace(1, 0, paths, kGoOn, stats).photons.size();
  EXPECT_NEAR(static_cast<double>(stored), 20'000, 1200);  // the pilot sees 3000: 2 %, 3 of them
}

TEST(PhotonQuota, ShootsNoEndOfPathsForLightThatHardlyLeavesAny) {
  // A small ball in front of a wide dark floor: one path in some thousands gets from there to
  // here.
  const auto job = sceneOf(
      "LightSource \"point\" \"point from\" [0 0 10] Material \"matte\" Translate 0 0 12 "
      "Shape \"sphere\" \"float radius\" .1 Material \"matte\" \"color Kd\" [.001 .001 .001] "
      "Translate 0 0 -7 Shape \"disk\" \"float radius\" 100 ");
  const PhotonTracer tracer(job->scene(), {kSurfacePhotons});
  const PhotonCounts counts = countOf(PhotonClass::SurfaceIndirect, 200'000);
  constexpr auto kIndirect = static_cast<std::size_t>(PhotonClass::SurfaceIndirect);
  Stats stats;
  const auto asked = [&](PhotonClasses optional) {
    return pathsFor(tracer, counts, optional, 1, kGoOn, stats)[kIndirect];
  };
  EXPECT_GT(asked({}), 100'000'000u);
  EXPECT_EQ(asked(PhotonClass::SurfaceIndirect), 64u * 200'000);
}

TEST(PhotonMapTracing, KeepsToItsTimeAndSaysSo) {
  const auto job = sceneOf(kFogBall + box("\"color sigma_a\" [.2 .2 .2]", 1));
  const PhotonTracer tracer(job->scene(), {kVolumePhotons});
  Stats stats;
  Log log({Verbosity::Normal, false, true});
  PrepareContext context{1, {0, 1}, kGoOn, stats, log};
  double share = 0;
  std::mutex mutex;
  context.onShare = [&](std::string_view what, double done) {
    const std::lock_guard lock(mutex);
    EXPECT_EQ(what, "tracing photons");
    share = std::max(share, done);
  };
  PathsPerClass paths{};
  paths[static_cast<std::size_t>(PhotonClass::VolumeUnscattered)] = 20'000;
  EXPECT_EQ(PhotonMapTracing(context).trace(tracer, paths).paths, paths);
  EXPECT_EQ(share, 1);
  EXPECT_THAT(log.captured(), testing::IsEmpty());

  // No time at all: the fewest paths.
  context.secondsForPhotons = 0;
  const PhotonMapTracing tracing(context);
  tracer.trace(2, 0, paths, kGoOn, stats);  // a pilot
  EXPECT_LT(tracing.secondsForPilots(), 0);
  PathsPerClass few{};
  few[static_cast<std::size_t>(PhotonClass::VolumeUnscattered)] = 1000;
  EXPECT_EQ(tracing.trace(tracer, paths).paths, few);
  EXPECT_THAT(log.captured(),
              testing::ElementsAre(testing::HasSubstr("--time leaves room for 1000 light paths")));
}

TEST(PhotonQuota, SaysWhyNothingIsStored) {
  // The light looks away from the medium.
  const auto job =
      sceneOf("LightSource \"spot\" \"point from\" [0 0 0] \"point to\" [0 0 -1] " +
              box("\"color sigma_s\" [1 1 1]", 1) + "Translate 0 0 -9 Shape \"sphere\" ");
  const PhotonTracer tracer(job->scene(), {kVolumePhotons});
  Stats stats;
  try {
    pathsFor(tracer, countOf(PhotonClass::VolumeUnscattered, 1000), {}, 1, kGoOn, stats);
    ADD_FAILURE();
  } catch (const SceneError& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("the lights do not reach there"));
  }
  EXPECT_EQ(pathsFor(tracer, countOf(PhotonClass::VolumeUnscattered, 1000),
                     PhotonClass::VolumeUnscattered, 1, kGoOn, stats),
            PathsPerClass{});
  const auto dark = sceneOf(box("\"color sigma_s\" [1 1 1]", 1));
  EXPECT_THROW(pathsFor(PhotonTracer(dark->scene(), {kVolumePhotons}),
                        countOf(PhotonClass::VolumeUnscattered, 1000), {}, 1, kGoOn, stats),
               SceneError);
}

}  // namespace
}  // namespace brume
