// SPDX-License-Identifier: Apache-2.0
#include "transport/radiance_photons.h"

#include <gtest/gtest.h>

#include "core/rng.h"
#include "renderers/render_job.h"
#include "support/make_plugin.h"
#include "support/render_text.h"

namespace brume {
namespace {

constexpr Vec3 kUp{0, 0, 1};

/// Photons of the irradiance E on a lattice over the square from -2 to 2 of the plane z = 0.
std::vector<Photon> lattice(float E, const Vec3& wi, float shift) {
  constexpr float kSpacing = 0.04f;
  std::vector<Photon> photons;
  for (int y = -50; y < 50; ++y)
    for (int x = -50; x < 50; ++x)
      photons.push_back(Photon::onSurface(
          kSpacing * Vec3(static_cast<float>(x) + shift, static_cast<float>(y) + shift, 0), wi, kUp,
          Rgb(E * kSpacing * kSpacing), PhotonClass::SurfaceIndirect));
  return photons;
}

/// Translucent: 3/8 of the light comes back, 1/8 goes through.
TEST(RadiancePhotons, RadianceOfBothSides) {
  const auto job = makeJob(
      "LookAt 0 0 0 0 0 1 0 1 0 Camera \"perspective\" WorldBegin\n"
      "Material \"translucent\" \"color Kd\" [.5 .5 .5] \"color Ks\" [0 0 0]\n"
      "  \"color reflect\" [.75 .75 .75] \"color transmit\" [.25 .25 .25]\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 2 3 0]\n"
      "  \"point P\" [-2 -2 0  2 -2 0  2 2 0  -2 2 0] WorldEnd",
      {}, test::captureLog());
  const Vec3 wi = normalize(Vec3(1, 2, 2));
  const std::vector<Photon> lit = lattice(2, wi, 0.3f), litBelow = lattice(5, -wi, 0.6f);
  const SurfacePhotonMap above{std::span<const Photon>(lit)},
      below{std::span<const Photon>(litBelow)};
  const SurfacePhotonMap* const maps[] = {&above, &below};
  Stats stats;
  const std::vector<Photon> sites = lattice(1, wi, 0.1f);
  const RadiancePhotons photons(job->scene(), sites, maps, {200, 1, 0}, stats);
  EXPECT_EQ(photons.size(), 2 * sites.size());  // one on each side
  Rng rng(4);
  for (int i = 0; i < 50; ++i) {
    const Vec3 p(2 * rng.uniform() - 1, 2 * rng.uniform() - 1, 0);
    const float expectedAbove = kInvPi * (.375f * 2 + .125f * 5);
    const float expectedBelow = kInvPi * (.375f * 5 + .125f * 2);
    // The circle of 200 photons, up to one photon's share and the lattice's raggedness.
    EXPECT_NEAR(photons.radiance(p, kUp).g, expectedAbove, 0.02f * expectedAbove);
    EXPECT_NEAR(photons.radiance(p, -kUp).g, expectedBelow, 0.02f * expectedBelow);
    EXPECT_EQ(photons.radiance(p, {1, 0, 0}), Rgb());
  }
}

TEST(RadiancePhotons, NoneGiveNothing) {
  const auto job = makeJob("Camera \"perspective\" WorldBegin Shape \"sphere\" WorldEnd", {},
                           test::captureLog());
  Stats stats;
  const RadiancePhotons photons(job->scene(), {}, {}, {}, stats);
  EXPECT_EQ(photons.size(), 0u);
  EXPECT_EQ(photons.radiance({0, 0, 0}, kUp), Rgb());
}

}  // namespace
}  // namespace brume
