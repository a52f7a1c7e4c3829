// SPDX-License-Identifier: Apache-2.0
#include "transport/first_radius.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/log.h"
#include "support/render_text.h"

namespace brume {
namespace {

/// The radius that --verbose tells of, of passes with so many paths.
double firstRadius(const std::string& medium, int paths, const std::string& what = "beams' ") {
  Log log({Verbosity::Verbose, false, true});
  const auto job =
      makeJob(fmt::format("LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 30\n"
                          "Film \"image\" \"integer xresolution\" 24 \"integer yresolution\" 24\n"
                          "Sampler \"random\" GlobalIntegrator \"pvpm\" \"integer passes\" 1 "
                          "\"integer photonsperpass\" {}\nWorldBegin {}\nWorldEnd\n",
                          paths, medium),
              {}, log);
  job->run(false, {}, {});
  for (const std::string& line : log.captured())
    if (const auto at = line.find(what + "first radius"); at != std::string::npos)
      return std::stod(line.substr(line.find(" is ", at) + 4));
  return 0;
}

const std::string kLight = "LightSource \"point\" \"point from\" [.2 .3 -.1] ";
std::string box(double half, double thickness, double depth) {
  return fmt::format(
      "Volume \"homogeneous\" \"color sigma_s\" [{0} {0} {0}] \"color sigma_a\" [.1 .1 .1] "
      "\"point p0\" [-{1} -{1} -{2}] \"point p1\" [{1} {1} {2}] ",
      depth, half, thickness);
}

TEST(FirstRadius, IsTheSameAfterAsManyPathsInAnyNumberOfPasses) {
  // r^2 falls as passes^(-1/3), so that of one pass must fall as paths^(-1/3).
  const std::string fog = kLight + box(1, 1, 2);
  EXPECT_NEAR(firstRadius(fog, 10'000) / firstRadius(fog, 80'000), std::sqrt(2.), 0.02);
}

TEST(FirstRadius, IsSmallerWhereTheLightIsSharper) {
  // The light of a sheet, seen from its side, changes over its thickness.
  const std::string side = "Rotate 90 1 0 0 ";
  const double fat = firstRadius(kLight + side + box(1, 1, 2), 20'000),
               thin = firstRadius(kLight + side + box(1, .1, 2), 20'000);
  EXPECT_LT(thin, 0.85 * fat);
  EXPECT_GT(thin, 0.2 * fat);
}

TEST(FirstRadius, DoesNotGrowWithDarkParts) {
  // Light reaches a few lengths far, however large the box is.
  const double small = firstRadius(kLight + box(20, 20, 2), 20'000);
  for (const double half : {1e4, 1e8, 1e17})
    EXPECT_NEAR(firstRadius(kLight + box(half, half, 2), 20'000) / small, 1, 0.1) << half;
}

TEST(FirstRadius, HasADefaultWhereNoPhotonsAre) {
  // A black medium behind the light's wall of the same: nothing is scattered twice.
  const double radius = firstRadius(
      "LightSource \"point\" \"point from\" [0 0 -4] Volume \"homogeneous\" "
      "\"color sigma_s\" [1e-9 1e-9 1e-9] \"point p0\" [-1 -1 -1] \"point p1\" [1 1 1] ",
      1000);
  EXPECT_NEAR(radius, 0.01 * std::sqrt(12.), 1e-4);
}

TEST(FirstRadius, OfSurfacesFollowsTheSameLaw) {
  const std::string room =
      kLight + "Material \"matte\" ReverseOrientation Shape \"sphere\" \"float radius\" 8 ";
  const double few = firstRadius(room, 10'000, "the "), many = firstRadius(room, 80'000, "the ");
  EXPECT_GT(many, 0);
  EXPECT_NEAR(few / many, std::sqrt(2.), 0.02);
}

}  // namespace
}  // namespace brume
