// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_store.h"

#include <gmock/gmock.h>

#include <cstring>

#include "core/log.h"
#include "support/photon_files.h"
#include "support/run_program.h"
#include "support/volumes.h"

namespace brume {
namespace {

const std::atomic<bool> kGoOn{false};

/// A box of fog from -1 to 1 around `center`, seen by a camera at the origin.
Scene fogAround(const Vec3d& center, const Vec3d& origin) {
  Scene::Contents contents;
  test::MediumSpec spec;
  spec.sigma_s = Rgb(1);
  const Vec3 middle(center - origin);
  spec.p0 = middle - Vec3(1);
  spec.p1 = middle + Vec3(1);
  contents.volumes.push_back(test::makeHomogeneous(spec));
  contents.sceneOrigin = origin;
  return Scene(std::move(contents));
}

class PhotonStore : public testing::Test {
 protected:
  PhotonSet run(const PhotonFileParams& files, const PhotonNeeds& needs,
                const Vec3d& origin = Vec3d(0), std::uint64_t seed = 5) {
    const Scene scene = fogAround(Vec3d(0), origin);
    const PrepareContext context{seed, {0, 1}, kGoOn, stats_, log_};
    return loadOrTracePhotons(files, needs, scene, context, [&] {
      ++traced_;
      return traceable_;
    });
  }
  std::string complaint(const PhotonFileParams& files, const PhotonNeeds& needs) {
    try {
      run(files, needs);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  }
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  const test::TemporaryFolder folder_;
  PhotonSet traceable_ = test::somePhotons(600).set;
  int traced_ = 0;
  Stats stats_;
  Log log_{Log::Options{Verbosity::Verbose, false, true}};
};

bool areEqual(const std::vector<Photon>& p, const std::vector<Photon>& q) {
  return p.size() == q.size() && std::memcmp(p.data(), q.data(), p.size() * sizeof(Photon)) == 0;
}

const PhotonNeeds kAll{kSurfacePhotons | kVolumePhotons, {}};

TEST_F(PhotonStore, LoadedPhotonsAreTheSavedOnes) {
  const PhotonSet saved = run({"", path("a")}, kAll);
  EXPECT_EQ(traced_, 1);
  const PhotonSet loaded = run({path("a"), ""}, kAll);
  EXPECT_EQ(traced_, 1);
  EXPECT_TRUE(areEqual(saved.photons, traceable_.photons));
  EXPECT_TRUE(areEqual(loaded.photons, traceable_.photons));
  EXPECT_EQ(loaded.paths, traceable_.paths);
  EXPECT_EQ(stats_[Stat::PhotonsStored], 600u);  // counted where they are traced, and here
  EXPECT_EQ(log_.warningCount(), 0);
}

TEST_F(PhotonStore, AnotherCameraSeesThemAtTheSamePlace) {
  run({"", path("a")}, kAll);
  const Vec3d origin(0, -1000, 0.5);
  const PhotonSet loaded = run({path("a"), path("b")}, kAll, origin);
  ASSERT_EQ(loaded.photons.size(), 600u);
  for (std::size_t i = 0; i < 600; ++i) {
    EXPECT_NEAR(loaded.photons[i].p.y, traceable_.photons[i].p.y + 1000, 7e-5);  // half a step
    EXPECT_NEAR(loaded.photons[i].p.z, traceable_.photons[i].p.z - 0.5f, 6e-8);
  }
  EXPECT_EQ(log_.warningCount(), 0);
  // What was loaded and saved anew lies at the new origin.
  EXPECT_EQ(readPhotonFile(path("b")).origin, origin);
}

TEST_F(PhotonStore, ClassesThatAreNotNeededStayOut) {
  run({"", path("a")}, kAll);
  const PhotonSet loaded =
      run({path("a"), ""}, {PhotonClass::VolumeMultiple, PhotonClass::VolumeCaustic});
  EXPECT_EQ(loaded.photons.size(), 200u);
  for (const Photon& photon : loaded.photons)
    EXPECT_THAT(photon.photonClass(),
                testing::AnyOf(PhotonClass::VolumeMultiple, PhotonClass::VolumeCaustic));
  EXPECT_EQ(loaded.paths, (PathsPerClass{0, 0, 0, 0, 14, 15}));
}

TEST_F(PhotonStore, AClassThatIsRequiredMustBeThere) {
  traceable_.paths[2] = traceable_.paths[4] = 0;
  std::erase_if(traceable_.photons, [](const Photon& p) {
    return p.photonClass() == PhotonClass::SurfaceIndirect ||
           p.photonClass() == PhotonClass::VolumeCaustic;
  });
  run({"", path("a")}, kAll);
  EXPECT_EQ(complaint({path("a"), ""}, {PhotonClass::SurfaceIndirect, {}}),
            "'" + path("a") +
                "' holds no photons of indirect light on surfaces, which this method needs");
  EXPECT_EQ(complaint({path("a"), ""}, {PhotonClass::SurfaceDirect, PhotonClass::VolumeCaustic}),
            "");
}

TEST_F(PhotonStore, AFileThatCannotBeWrittenShowsBeforeTracing) {
  EXPECT_THAT(complaint({"", path("none/a")}, kAll), testing::HasSubstr("cannot write"));
  EXPECT_EQ(traced_, 0);
}

TEST_F(PhotonStore, AnInterruptedPassIsNotSaved) {
  traceable_.isComplete = false;
  run({"", path("a")}, kAll);
  EXPECT_TRUE(folder_.files().empty());
}

TEST_F(PhotonStore, PhotonsOfAnotherSceneAreWarnedOf) {
  for (std::size_t i = 0; i < 7; ++i) traceable_.photons[i].p.x = 3;
  run({"", path("a")}, kAll);
  run({path("a"), ""}, kAll);
  EXPECT_EQ(log_.warningCount(), 1);
  EXPECT_THAT(log_.captured(),
              testing::Contains(testing::HasSubstr("7 of the 600 photons in '" + path("a") +
                                                   "' lie outside of the scene")));
}

}  // namespace
}  // namespace brume
