// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_mirror.h"

#include <gtest/gtest.h>

#include "core/rng.h"
#include "support/make_plugin.h"
#include "support/render_text.h"
#include "transport/kernels.h"

namespace brume {
namespace {

std::unique_ptr<RenderJob> media(const std::string& volumes) {
  Log log({Verbosity::Quiet, false, true});
  return makeJob("Camera \"perspective\" WorldBegin " + volumes + " WorldEnd", {}, log);
}
std::string box(const std::string& rest) {
  return "Volume \"homogeneous\" \"point p0\" [-1 -1 -1] \"point p1\" [1 1 1] " + rest;
}
const std::string kThin = "\"color sigma_s\" [1e-6 1e-6 1e-6] ";

TEST(PhotonMirror, EvenPhotonsStayEvenUpToFacesEdgesAndCorners) {
  // A turned box, photons as even as can be: the sum of kernels around any point of it is 1.
  const auto job = media("Translate 3 2 1 Rotate 30 1 2 3 Scale 2 1 1.5 " + box(kThin));
  const Transform toWorld = Transform::translate({3, 2, 1}) * Transform::rotate(30, {1, 2, 3}) *
                            Transform::scale(2, 1, 1.5);
  const PhotonMirror mirror(*job->scene().volume());
  ASSERT_FALSE(mirror.isEmpty());
  constexpr float kRadius = 0.5f;
  constexpr int kPerSide = 56;
  const float volume = 8 * 3.f / (kPerSide * kPerSide * kPerSide);
  const auto toRender = [&](const Vec3& p) {
    return Vec3(Vec3d(toWorld.point(p)) - job->scene().sceneOrigin());
  };
  std::vector<Vec3> photons, images;
  Rng rng(2);
  for (int x = 0; x < kPerSide; ++x)
    for (int y = 0; y < kPerSide; ++y)
      for (int z = 0; z < kPerSide; ++z) {
        const Vec3 jitter(rng.uniform(), rng.uniform(), rng.uniform());
        photons.push_back(toRender((Vec3(x, y, z) + jitter) * (2.f / kPerSide) - Vec3(1)));
        mirror.forEachImage(photons.back(), kRadius, [&](const Vec3& image, const Rgb& share) {
          images.push_back(image);
          EXPECT_NEAR(share.g, 1, 1e-5f);
        });
      }
  const BallKernel kernel(sqr(kRadius));
  const auto sum = [&](const std::vector<Vec3>& points, const Vec3& at) {
    double total = 0;
    for (const Vec3& p : points) total += double{kernel(lengthSquared(p - at))} * double{volume};
    return total;
  };
  for (const Vec3& local : {Vec3(0), Vec3(1, 0, 0), Vec3(0, -1, .2f), Vec3(.99f, .98f, 0),
                            Vec3(-1, 1, -1), Vec3(.9f, -.9f, .9f)}) {
    const Vec3 at = toRender(local);
    EXPECT_NEAR(sum(photons, at) + sum(images, at), 1, 0.02) << local.x << ' ' << local.y;
  }
  EXPECT_NEAR(sum(photons, toRender(Vec3(-1, 1, -1))), 0.125, 0.01);  // without images
}

TEST(PhotonMirror, ImagesFadeOverTheExtrapolationLength) {
  const auto job = media(box("\"color sigma_s\" [1 2 0] \"color sigma_a\" [1 0 0] \"float g\" .5"));
  const PhotonMirror mirror(*job->scene().volume());
  int count = 0;
  const Vec3 inside(Vec3d(0, .1, .9) - job->scene().sceneOrigin());
  mirror.forEachImage(inside, .2f, [&](const Vec3& image, const Rgb& share) {
    ++count;
    EXPECT_NEAR(distance(image, inside), .2f, 1e-5f);
    // 2 x / z0 = 3 (1 - g) sigma_t x = 0.15 sigma_t
    EXPECT_NEAR(share.r, std::exp(-.3f), 1e-5f);
    EXPECT_NEAR(share.g, std::exp(-.3f), 1e-5f);
    EXPECT_NEAR(share.b, 1, 1e-5f);
  });
  EXPECT_EQ(count, 1);
}

TEST(PhotonMirror, OnlyOneBoxHasImages) {
  EXPECT_TRUE(PhotonMirror(*media(box(kThin) + "Translate 1 0 0 " + box(kThin))->scene().volume())
                  .isEmpty());
}

}  // namespace
}  // namespace brume
