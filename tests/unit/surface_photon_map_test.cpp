// SPDX-License-Identifier: Apache-2.0
#include "transport/surface_photon_map.h"

#include <gtest/gtest.h>

#include "core/rng.h"
#include "support/render_text.h"

namespace brume {
namespace {

constexpr double kMaxZ = 4;  // fails by chance once in 16,000

/// The same value for all pairs of directions on one side [1/sr].
class EvenLobe final : public Lobe {
 public:
  explicit EvenLobe(float value) : Lobe(kReflection | kDiffuse), value_(value) {}
  Rgb f(const Vec3&, const Vec3&) const override { return Rgb(value_); }

 private:
  float value_;
};

constexpr float kF = 0.25f;  // [1/sr]

/// The radiance at p on a plane of normal n, seen along n, by a map and a choice of estimate.
struct Query {
  Query(const Vec3& p, const Vec3& n, const Vec3& ns) {
    at.p = p;
    at.n = n;
    at.ns = ns;
    at.wo = n;
    bsdf.reset(ns, Vec3(ns.y, ns.z, ns.x), n);
    bsdf.add<EvenLobe>(kF);
  }
  Query(const Vec3& p, const Vec3& n) : Query(p, n, n) {}
  SurfaceInteraction at;
  Bsdf bsdf;
};

constexpr Vec3 kUp{0, 0, 1};

/// Photons of unit density [length^-2] on the square of half-width `half` of the plane z = 0, light
/// from `wi`, each of the power `power` [W].
std::vector<Photon> scattered(float half, const Rgb& power, const Vec3& wi, Rng& rng) {
  const int n = static_cast<int>(4 * half * half);
  std::vector<Photon> photons;
  for (int i = 0; i < n; ++i) {
    const Vec3 p(half * (2 * rng.uniform() - 1), half * (2 * rng.uniform() - 1), 0);
    photons.push_back(Photon::onSurface(p, wi, kUp, power, PhotonClass::SurfaceIndirect));
  }
  return photons;
}

struct Mean {
  double value = 0, standardError = 0;
  double z(double expected) const { return (value - expected) / standardError; }
};
template <class F>
Mean meanOf(int n, F&& f) {
  double sum = 0, squares = 0;
  for (int i = 0; i < n; ++i) {
    const double v = f(i);
    sum += v;
    squares += v * v;
  }
  const double mean = sum / n;
  return {mean, std::sqrt((squares / n - mean * mean) / (n - 1))};
}

TEST(SurfacePhotonMap, EvenLightGivesItsIrradianceTimesTheBsdf) {
  // Photons on a fine lattice are as even as can be: sum K2 over it is the integral of K2 but for
  // terms of the order (spacing / radius)^3.
  std::vector<Photon> photons;
  const Vec3 wi = normalize(Vec3(1, 2, 2));
  constexpr int kHalf = 60;
  constexpr float kSpacing = 0.1f, kIrradiance = 3;
  for (int y = -kHalf; y <= kHalf; ++y)
    for (int x = -kHalf; x <= kHalf; ++x)
      photons.push_back(Photon::onSurface(
          {kSpacing * static_cast<float>(x), kSpacing * static_cast<float>(y), 0}, wi, kUp,
          Rgb(kIrradiance, 1, 0) * sqr(kSpacing), PhotonClass::SurfaceIndirect));
  const SurfacePhotonMap map{std::span<const Photon>(photons)};
  const Query query({0.03f, 0.01f, 0}, kUp);
  const Rgb within = map.radiance(query.at, query.bsdf, 2.5f);
  EXPECT_NEAR(within.r, kF * kIrradiance, 1e-3f * kF * kIrradiance);
  EXPECT_NEAR(within.g, kF, 1e-3f * kF);
  EXPECT_EQ(within.b, 0);
  // k = 1500: the radius is that of a circle, up to one photon's share.
  const Rgb nearest = map.radianceOfNearest(query.at, query.bsdf, 1500, 100);
  EXPECT_NEAR(nearest.r, kF * kIrradiance, 3e-3f * kF * kIrradiance);
  // Fewer than k within reach: all of them, by that reach, summed in another order.
  EXPECT_NEAR(map.radianceOfNearest(query.at, query.bsdf, 5000, 2.5f).r, within.r, 1e-5f);
}

TEST(SurfacePhotonMap, NearestAreUnbiasedForAnyNumber) {
  // With few neighbours the estimate that counts the k-th is too bright by k/(k-1): a half for 3
  // (with 2 the variance is infinite).
  Rng rng(7);
  const std::vector<Photon> photons = scattered(110, Rgb(1), kUp, rng);
  const SurfacePhotonMap map{std::span<const Photon>(photons)};
  for (const std::size_t k : {3, 4, 8, 50}) {
    const Mean mean = meanOf(k > 10 ? 400 : 4000, [&](int) {
      const Query query({200 * rng.uniform() - 100, 200 * rng.uniform() - 100, 0}, kUp);
      return double{map.radianceOfNearest(query.at, query.bsdf, k, kInfinity).r};
    });
    EXPECT_LT(std::abs(mean.z(double{kF})), kMaxZ) << k << ": " << mean.value;
  }
}

TEST(SurfacePhotonMap, FixedRadiusIsUnbiasedOnEvenLight) {
  Rng rng(8);
  const std::vector<Photon> photons = scattered(110, Rgb(1), kUp, rng);
  const SurfacePhotonMap map{std::span<const Photon>(photons)};
  for (const float radius : {0.5f, 3.f}) {
    const Mean mean = meanOf(2000, [&](int) {
      const Query query({200 * rng.uniform() - 100, 200 * rng.uniform() - 100, 0}, kUp);
      return double{map.radiance(query.at, query.bsdf, radius).r};
    });
    EXPECT_LT(std::abs(mean.z(double{kF})), kMaxZ) << radius << ": " << mean.value;
  }
}

TEST(SurfacePhotonMap, ShadingNormalsWeighTheIrradiance) {
  // Light from wi gives |wi.ns| / |wi.n| times as much to a surface that is shaded as if it leant.
  const Vec3 wi = normalize(Vec3(1, 0, 1)), ns = normalize(Vec3(0.3f, 0, 1));
  std::vector<Photon> photons{
      Photon::onSurface({0.1f, 0, 0}, wi, kUp, Rgb(1), PhotonClass::SurfaceCaustic)};
  const SurfacePhotonMap map{std::span<const Photon>(photons)};
  const Query flat({0, 0, 0}, kUp), leaning({0, 0, 0}, kUp, ns);
  const float ratio =
      map.radiance(leaning.at, leaning.bsdf, 1).r / map.radiance(flat.at, flat.bsdf, 1).r;
  EXPECT_NEAR(ratio, dot(wi, ns) / dot(wi, kUp), 1e-4f);  // directions are stored to 7e-5
}

TEST(SurfacePhotonMap, PhotonsCountByTheSurfaceWhereTheyLie) {
  // Light that falls steeply on a neighbouring facet and grazes this one gives it little, however
  // its normal is shaded: dividing by the cosine here instead would make it 100 times too bright.
  const Vec3 facet = normalize(Vec3(0.8f, 0, 1)), wi = normalize(Vec3(1, 0, 0.01f));
  const std::vector<Photon> photons{
      Photon::onSurface({0.1f, 0, 0}, wi, facet, Rgb(1), PhotonClass::SurfaceIndirect)};
  const SurfacePhotonMap map{std::span<const Photon>(photons)};
  const double kernel = 3 / M_PI * sqr(1 - 0.1 * 0.1);
  for (const Vec3& ns : {kUp, normalize(Vec3(0.3f, 0, 1))}) {
    const Query query({0, 0, 0}, kUp, ns);
    const double expected = double{kF} * kernel * double{dot(wi, ns) / dot(wi, facet)};
    // Directions are stored to 7e-5, of which the cosine of 0.01 knows 0.7 %, normals to 1e-3.
    EXPECT_NEAR(double{map.radiance(query.at, query.bsdf, 1).r}, expected, 0.01 * expected);
  }
}

TEST(SurfacePhotonMap, NoLightLeaksAroundACorner) {
  // A lit wall x = 0 meets a dark floor z = 0, and a second floor lies below the first.
  Rng rng(3);
  std::vector<Photon> photons;
  for (int i = 0; i < 2000; ++i) {
    const float a = 2 * rng.uniform() - 1, b = rng.uniform();
    photons.push_back(Photon::onSurface({0, a, b}, normalize(Vec3(1, 0, 1)), {1, 0, 0}, Rgb(1),
                                        PhotonClass::SurfaceIndirect));
    photons.push_back(
        Photon::onSurface({b, a, -0.1f}, kUp, kUp, Rgb(1), PhotonClass::SurfaceIndirect));
    // Light that falls on the floor's underside.
    photons.push_back(
        Photon::onSurface({b, a, 0}, -kUp, kUp, Rgb(1), PhotonClass::SurfaceIndirect));
  }
  const SurfacePhotonMap map{std::span<const Photon>(photons)};
  const Query floor({0.05f, 0, 0}, kUp), wall({0, 0, 0.2f}, {1, 0, 0});
  EXPECT_EQ(map.radiance(floor.at, floor.bsdf, 0.3f), Rgb());
  EXPECT_EQ(map.radianceOfNearest(floor.at, floor.bsdf, 50, 0.3f), Rgb());
  EXPECT_GT(map.radiance(wall.at, wall.bsdf, 0.3f).r, 0);
}

/// A box with its corner in the middle of the space, and a floor and a wall that cross at y = 20.
std::unique_ptr<RenderJob> cornerAndEdge() {
  Log log({Verbosity::Quiet, false, true});
  return makeJob(
      "Camera \"perspective\" WorldBegin "
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3  0 1 5 0 5 4] "
      "\"point P\" [-9 0 0  9 0 0  9 9 0  -9 9 0  -9 0 -9  9 0 -9] "
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] "
      "\"point P\" [-9 12 0  9 12 0  9 30 0  -9 30 0] "
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] "
      "\"point P\" [-9 20 -9  9 20 -9  9 20 9  -9 20 9] WorldEnd",
      {}, log);
}

TEST(SurfacePhotonMap, EvenLightStaysEvenUpToEdges) {
  // Unit irradiance on the box's top, y in (0, 9), and side, z in (-9, 0); on the floor before the
  // wall, y in (12, 20), three times as much behind it, and on the wall above the floor.
  Rng rng(5);
  std::vector<Photon> photons;
  const auto add = [&](const Vec3& p, const Vec3& n, float power) {
    photons.push_back(Photon::onSurface(p, n, n, Rgb(power), PhotonClass::SurfaceIndirect));
  };
  constexpr int kPerSide = 10, kPerArea = kPerSide * kPerSide;  // one photon in each small square
  for (int ix = 0; ix < 18 * kPerSide; ++ix)
    for (int iy = 0; iy < 9 * kPerSide; ++iy) {
      const auto along = [&](int i) { return (static_cast<float>(i) + rng.uniform()) / kPerSide; };
      const float x = along(ix) - 9;
      add({x, along(iy), 0}, kUp, 1);
      add({x, 0, -along(iy)}, {0, -1, 0}, 1);
      add({x, 11 + along(iy), 0}, kUp, 1);
      add({x, 20 + along(iy), 0}, kUp, 3);
      add({x, 20, along(iy)}, {0, -1, 0}, 1);
    }
  const auto job = cornerAndEdge();
  const SurfacePhotonMap blind{std::span<const Photon>(photons)},
      seeing(std::span<const Photon>(photons), &job->scene().accelerator());
  const auto meanAt = [&](const SurfacePhotonMap& map, float y) {
    return meanOf(300, [&](int) {
      const Query query({14 * rng.uniform() - 7, y, 0}, kUp);
      return double{map.radiance(query.at, query.bsdf, 1).r} / (kF * kPerArea);
    });
  };
  for (const float y : {0.02f, 0.3f, 0.7f, 19.3f, 19.7f, 19.98f}) {
    const Mean mean = meanAt(seeing, y);
    // Photons of one square noise by a per cent; 1/share of eight directions is 1 % too bright.
    EXPECT_NEAR(mean.value, 1, 0.03) << y;
  }
  EXPECT_LT(meanAt(blind, 0.02f).value, 0.6);
  EXPECT_GT(meanAt(blind, 19.98f).value, 1.5);  // what lies behind the wall
}

TEST(SurfacePhotonMap, NothingComesOfNothing) {
  const SurfacePhotonMap none{std::span<const Photon>()};
  EXPECT_TRUE(none.isEmpty());
  const Query query({0, 0, 0}, kUp);
  EXPECT_EQ(none.radiance(query.at, query.bsdf, 1), Rgb());
  EXPECT_EQ(none.radianceOfNearest(query.at, query.bsdf, 10, 1), Rgb());
  // All photons at one point: the k-th is at distance 0, which is no radius; fewer than k in an
  // unlimited reach have none either.
  const std::vector<Photon> photons(
      20, Photon::onSurface({0, 0, 0}, kUp, kUp, Rgb(1), PhotonClass::SurfaceIndirect));
  const SurfacePhotonMap one{std::span<const Photon>(photons)};
  EXPECT_EQ(one.radianceOfNearest(query.at, query.bsdf, 10, 1), Rgb());
  EXPECT_EQ(one.radianceOfNearest(query.at, query.bsdf, 30, kInfinity), Rgb());
  EXPECT_EQ(one.radiance(query.at, query.bsdf, 0), Rgb());
  EXPECT_NEAR(one.radiance(query.at, query.bsdf, 1).r, 20 * 3 * kInvPi * kF, 1e-4f);
}

}  // namespace
}  // namespace brume
