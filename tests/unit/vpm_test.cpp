// SPDX-License-Identifier: Apache-2.0
// GlobalIntegrator "vpm": checks that it shares with "bre", whose tests cover the common code. Its
// sums and their bias are tested in photon_estimates_test.
#include <gtest/gtest.h>

#include "support/photon_methods.h"

namespace brume {
namespace {

TEST(Vpm, WhiteFurnace) { test::checkFurnace("vpm"); }
TEST(Vpm, AgreesWithVolpath) { test::checkAgainstVolpath("vpm"); }
TEST(Vpm, AgreesWithVolpathAroundSurfaces) { test::checkSurfacesAgainstVolpath("vpm"); }
TEST(Vpm, CountsNoPhotonBehindAWall) { test::checkWall("vpm"); }
TEST(Vpm, DoesNotDependOnThreads) { test::checkThreads("vpm"); }
TEST(Vpm, SaysWhereNoPhotonsAre) { test::checkScarcity("vpm"); }
TEST(Vpm, WarnsOfPhotonsOnWhatMoves) { test::checkMotion("vpm"); }

}  // namespace
}  // namespace brume
