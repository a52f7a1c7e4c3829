// SPDX-License-Identifier: Apache-2.0
// `brume photons`: summary and point cloud; photon files that a render cannot use.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstring>
#include <filesystem>

#include "support/photon_files.h"
#include "support/run_program.h"

namespace brume::test {
namespace {

using testing::HasSubstr;

class Photons : public testing::Test {
 protected:
  ProgramResult run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "photons");
    return runBrume({arguments, folder_.path()});
  }
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  const TemporaryFolder folder_;
};

/// Two photons that can be reckoned by heart.
PhotonFile twoPhotons() {
  PhotonFile file;
  file.origin = {10, 20, 1e6};
  file.seed = 42;
  file.set.paths[1] = 1000;
  file.set.paths[5] = 50;
  file.set.photons = {
      Photon::onSurface({1, 2, 3}, {0, 0, 1}, {0, 0, 1}, {2, 1, 0}, PhotonClass::SurfaceCaustic),
      Photon::inMedium({-1, 0, 0.25f}, {1, 0, 0}, {0.5f, 0.25f, 2}, PhotonClass::VolumeMultiple)};
  return file;
}

TEST_F(Photons, SummaryOfEachClass) {
  writePhotonFile(path("map"), twoPhotons());
  const ProgramResult result = run({"map"});
  EXPECT_EQ(result.exitCode, 0);
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(result.out,
            "map: photon file, version 1\n"
            "  photons                       2   64 bytes\n"
            "  seed                         42\n"
            "  origin             10 20 1e+06\n"
            "  bounds             9 20 1e+06 to 11 22 1e+06\n"
            "\n"
            "  class                   photons  light paths   power of all, R G B [W]\n"
            "  surface direct       not traced\n"
            "  surface caustic               1         1000   2 1 0\n"
            "  surface indirect     not traced\n"
            "  volume unscattered   not traced\n"
            "  volume caustic       not traced\n"
            "  volume multiple               1           50   0.5 0.25 2\n");
}

TEST_F(Photons, PointCloud) {
  writePhotonFile(path("map"), twoPhotons());
  ASSERT_EQ(run({"map", "--ply", "cloud.ply"}).exitCode, 0);
  const std::string ply = readFile(path("cloud.ply"));
  const std::string end = "end_header\n";
  EXPECT_TRUE(ply.starts_with("ply\nformat binary_little_endian 1.0\n"));
  EXPECT_THAT(ply, HasSubstr("\nelement vertex 2\n"));
  const std::size_t body = ply.find(end) + end.size();
  constexpr std::size_t kVertex = 3 * 8 + 4 + 6 * 4;
  ASSERT_EQ(ply.size(), body + 2 * kVertex);
  double position[3];
  std::memcpy(position, ply.data() + body, sizeof position);
  EXPECT_EQ(position[0], 11);
  EXPECT_EQ(position[1], 22);
  EXPECT_EQ(position[2], 1e6 + 3);
  // White is the power of the strongest; half of it is 188 in sRGB.
  EXPECT_EQ(ply.substr(body + 24, 4), std::string("\xff\xbc\x00\x01", 4));
  float numbers[6];
  std::memcpy(numbers, ply.data() + body + kVertex + 28, sizeof numbers);
  EXPECT_EQ(numbers[2], 2);
  EXPECT_EQ(numbers[3], 1);
}

TEST_F(Photons, ErrorsExitWith1) {
  folder_.write("text", "no photons\n");
  const ProgramResult foreign = run({"text"});
  EXPECT_EQ(foreign.exitCode, 1);
  EXPECT_EQ(foreign.err, "brume: error: 'text' is not a photon file of brume\n");
  EXPECT_EQ(run({"missing"}).exitCode, 1);
  EXPECT_EQ(run({}).exitCode, 1);
  writePhotonFile(path("map"), twoPhotons());
  const ProgramResult unwritable = run({"map", "--ply", "none/cloud.ply"});
  EXPECT_EQ(unwritable.exitCode, 1);
  EXPECT_THAT(unwritable.err, HasSubstr("cannot write 'none/cloud.ply'"));
  EXPECT_EQ(run({"map", "--spp", "4"}).exitCode, 1);
}

TEST_F(Photons, ErrorsOfMapsNameTheIntegratorsPlace) {
  folder_.write("scene.pbrt",
                "Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8\n"
                "GlobalIntegrator \"bre\" \"string loadphotons\" \"none\"\nWorldBegin\n"
                "LightSource \"point\" Volume \"homogeneous\" \"color sigma_s\" [1 1 1]\n"
                "WorldEnd\n");
  const ProgramResult result = runBrume({{"scene.pbrt"}, folder_.path()});
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_THAT(result.err, HasSubstr("scene.pbrt:2:18: error: cannot read 'none': No such file"));
  const ProgramResult given =
      runBrume({{"scene.pbrt", "--integrator", "vpm:loadphotons=text"}, folder_.path()});
  EXPECT_EQ(given.exitCode, 1);
  EXPECT_THAT(given.err, HasSubstr("brume: error: cannot read 'text'"));
  const ProgramResult checked = runBrume({{"scene.pbrt", "--check"}, folder_.path()});
  EXPECT_EQ(checked.exitCode, 1);
  EXPECT_EQ(checked.err, result.err);
}

TEST_F(Photons, CheckReadsMapsUnlessAnEarlierFrameWritesThem) {
  const auto frame = [](const char* integrator, const char* parameter) {
    return fmt::format(
        "Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8\n"
        "  \"string filename\" \"{0}.exr\"\n{0}Integrator {1}\nWorldBegin\n"
        "LightSource \"point\" Volume \"homogeneous\" \"color sigma_s\" [1 1 1]\n"
        "AttributeBegin Translate 0 -1 0 Shape \"sphere\" \"float radius\" .1 AttributeEnd\n"
        "WorldEnd\n",
        integrator, parameter);
  };
  const std::string saves =
      frame("Global", "\"pvpm\" \"integer photonsperpass\" 99 \"string savephotons\" \"map\"");
  for (const auto& [integrator, loads] :
       {std::pair{"Global", "\"bre\" \"string loadphotons\" \"map\""},
        std::pair{"Global", "\"pvpm\" \"integer passes\" 1 \"string loadphotons\" \"map\""},
        std::pair{"Surface", "\"photonmap\" \"string loadphotons\" \"map\""}}) {
    folder_.write("loads.pbrt", frame(integrator, loads));
    folder_.write("both.pbrt", saves + frame(integrator, loads));
    const auto check = [&](const char* scene) {
      return runBrume({{scene, "--check"}, folder_.path()}).exitCode;
    };
    std::filesystem::remove(path("map"));
    EXPECT_EQ(check("loads.pbrt"), 1) << loads;
    EXPECT_EQ(check("both.pbrt"), 0) << loads;
    folder_.write("map", "foreign");
    EXPECT_EQ(check("loads.pbrt"), 1) << loads;
    EXPECT_EQ(check("both.pbrt"), 0) << loads;
  }
}

TEST_F(Photons, AFrameThatReplacesTheMapOfAnEarlierOneIsWarnedAbout) {
  const auto frame = [](int n) {
    return fmt::format(
        "Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8\n"
        "  \"string filename\" \"{}.exr\"\nWorldBegin\n"
        "LightSource \"point\" Volume \"homogeneous\" \"color sigma_s\" [1 1 1]\nWorldEnd\n",
        n);
  };
  folder_.write("two.pbrt", frame(1) + frame(2));
  for (const char* action : {"--quick", "--check"}) {
    const ProgramResult result = runBrume(
        {{"two.pbrt", action, "--integrator", "bre:photons=99,savephotons=map"}, folder_.path()});
    EXPECT_EQ(result.exitCode, 0) << result.err;
    EXPECT_THAT(result.err,
                HasSubstr("warning: this frame replaces 'map', which an earlier frame wrote"));
  }
}

}  // namespace
}  // namespace brume::test
