// SPDX-License-Identifier: Apache-2.0
#include "transport/pass_balance.h"

#include <gtest/gtest.h>

#include "core/stats.h"
#include "support/render_text.h"

namespace brume {
namespace {

TEST(PassBalance, LightPathsCostWhatCameraPathsDo) {
  // 3 segments and 1 photon: 8 segments a path.
  EXPECT_EQ(balancedPaths(100'000, {3, 1}), 150'000);
  EXPECT_EQ(balancedPaths(400'000, {3, 1}), 600'000);
  // Long paths in dense fog are fewer.
  EXPECT_EQ(balancedPaths(110'000, {10, 9}), 24'000);
}

TEST(PassBalance, IsBounded) {
  EXPECT_EQ(balancedPaths(1, {2, 1}), 1000);
  EXPECT_EQ(balancedPaths(0, {0, 0}), 1000);
  // Photons, and so memory.
  EXPECT_EQ(balancedPaths(1'000'000'000, {1, 8}), (2 << 20) / 8);
  EXPECT_EQ(balancedPaths(std::int64_t{1} << 60, {1, 0}), 1 << 30);
}

std::uint64_t pathsOf(const std::string& parameters, int pixels) {
  const RenderResult result = renderText(
      "LookAt 0 0 -4 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 40\n"
      "PixelFilter \"box\" Film \"image\" \"integer xresolution\" " +
      std::to_string(pixels) + " \"integer yresolution\" " + std::to_string(pixels) +
      "\nGlobalIntegrator \"pvpm\" \"integer passes\" 2 " + parameters +
      " WorldBegin LightSource \"point\" \"color I\" [2 2 2]\n"
      "Volume \"homogeneous\" \"color sigma_s\" [2 2 2] \"point p0\" [-1 -1 -1]\nWorldEnd\n");
  return result.stats[Stat::PhotonPaths];
}

TEST(PassBalance, PvpmTracesMoreLightForMorePixels) {
  const std::uint64_t pilots = pathsOf("\"integer photonsperpass\" 1", 16) - 2;
  const double few = static_cast<double>(pathsOf("", 64) - pilots),
               many = static_cast<double>(pathsOf("", 128) - pilots);
  EXPECT_GT(few, 2 * 1000);
  EXPECT_NEAR(many / few, 4, 0.01);
  // What is given is taken.
  EXPECT_EQ(pathsOf("\"integer photonsperpass\" 700", 64), pilots + 1400);
}

}  // namespace
}  // namespace brume
