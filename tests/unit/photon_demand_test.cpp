// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_demand.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/render_text.h"
#include "support/run_program.h"
#include "transport/photon_file.h"
#include "transport/photon_sources.h"

namespace brume {
namespace {

/// A box of fog with a lamp in it, small on a wide floor under the sky: the light that comes to it
/// is a small part of all, straight or off any part of the floor.
std::string fogScene(const std::string& integrator, const std::string& photonFile,
                     const std::string& crop = "") {
  return fmt::format(R"(
    Film "image" "integer xresolution" 16 "integer yresolution" 12 {}
    Sampler "lowdiscrepancy" "integer pixelsamples" 1
    GlobalIntegrator "{}" "integer photons" 20000 "integer surfacephotons" 20000
      "string savephotons" "{}"
    LookAt 0 2.5 -8  0 1.2 0  0 1 0
    Camera "perspective" "float fov" 45
    WorldBegin
    LightSource "point" "point from" [1 4 -1] "color I" [30 30 30]
    LightSource "infinite" "color L" [.1 .1 .1]
    Volume "homogeneous" "point p0" [-5 -1 -5] "point p1" [5 5 5]
      "color sigma_s" [.4 .4 .4] "float g" .9
    Material "matte"
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
      "point P" [-50 0 -50  50 0 -50  50 0 50  -50 0 50]
    WorldEnd)",
                     crop, integrator, photonFile);
}

/// (sum P)^2 / sum P^2 of the photons on surfaces or of those in media, over their number: 1 where
/// all have equal power.
double evenness(const PhotonSet& set, bool onSurfaces) {
  double n = 0, sum = 0, squares = 0;
  for (const Photon& photon : set.photons) {
    if (photon.isOnSurface() != onSurfaces) continue;
    const auto P = double{largestChannel(photon.power)};
    n += 1, sum += P, squares += P * P;
  }
  return sum * sum / (squares * n);
}

TEST(PhotonDemand, PhotonsOfAMapHaveAboutEqualPower) {
  const test::TemporaryFolder folder;
  for (const std::string integrator : {"bre", "vpm"}) {
    const std::string file = (folder.path() / integrator).string();
    renderText(fogScene(integrator, file));
    const PhotonSet set = readPhotonFile(file).set;
    // Half of the paths towards the medium, the others spread over all shells, gave 0.12 and 0.11.
    EXPECT_GT(evenness(set, false), 0.5) << integrator;
    EXPECT_GT(evenness(set, true), 0.5) << integrator;
  }
}

/// Parts of an image that are rendered one by one fit together.
TEST(PhotonDemand, IsThatOfTheWholeImage) {
  const test::TemporaryFolder folder;
  const auto photons = [&](const std::string& crop) {
    const std::string file = (folder.path() / "photons").string();
    renderText(fogScene("bre", file, crop));
    return test::readFile(file);
  };
  EXPECT_TRUE(photons("") == photons("\"float cropwindow\" [.5 1 0 .5]"));
}

}  // namespace
}  // namespace brume
