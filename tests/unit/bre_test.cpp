// SPDX-License-Identifier: Apache-2.0
// GlobalIntegrator "bre": the checks that it shares with its kin. Its sums and their bias are
// tested in photon_estimates_test.
#include <gtest/gtest.h>

#include "support/photon_methods.h"

namespace brume {
namespace {

TEST(Bre, WhiteFurnace) { test::checkFurnace("bre"); }
TEST(Bre, AgreesWithVolpath) { test::checkAgainstVolpath("bre"); }
TEST(Bre, AgreesWithVolpathAroundSurfaces) { test::checkSurfacesAgainstVolpath("bre"); }
TEST(Bre, CountsNoPhotonBehindAWall) { test::checkWall("bre"); }
TEST(Bre, DoesNotDependOnThreads) { test::checkThreads("bre"); }
TEST(Bre, SaysWhereNoPhotonsAre) { test::checkScarcity("bre"); }
TEST(Bre, WarnsOfPhotonsOnWhatMoves) { test::checkMotion("bre"); }

}  // namespace
}  // namespace brume
