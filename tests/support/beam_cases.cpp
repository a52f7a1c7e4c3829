// SPDX-License-Identifier: Apache-2.0
#include "support/beam_cases.h"

#include <algorithm>

#include "core/ray.h"
#include "core/sampling.h"

namespace brume::test {
namespace {

/// A ray through the raster position (x, y) of an image of the scene's resolution.
Ray rayOf(const BeamScene& scene, Vec2 raster, Rng& rng) {
  const Vec2 size(scene.resolution);
  const Vec2 p = (2.f * raster - size) / std::max(size.x, size.y);
  const Ray pinhole{Vec3(0), normalize(Vec3(p.x, -p.y, 1.2f))};
  switch (scene.rays) {
    case Rays::Pinhole:
      return pinhole;
    case Rays::ThinLens: {
      const Vec3 lens(0.1f * (rng.uniform() - 0.5f), 0.1f * (rng.uniform() - 0.5f), 0);
      return {lens, normalize(3.f * pinhole.d - lens)};
    }
    case Rays::Orthographic:
      return {Vec3(2.f * p.x, -2.f * p.y, 0), Vec3(0, 0, 1)};
    case Rays::Environment: {
      const float theta = kPi * raster.y / size.y, phi = 2 * kPi * raster.x / size.x;
      return {Vec3(0), normalize(Vec3(std::sin(theta) * std::cos(phi),
                                      std::sin(theta) * std::sin(phi), std::cos(theta)))};
    }
    case Rays::Mirrored: {
      // Off a sphere of radius 1 at z = 3; rays that miss it stay as they are.
      const Vec3 center(0, 0, 3);
      const float b = dot(pinhole.d, center), d = sqr(b) - lengthSquared(center) + 1;
      if (d < 0) return pinhole;
      const Vec3 hit = (b - std::sqrt(d)) * pinhole.d, n = normalize(hit - center);
      return {hit, normalize(pinhole.d - 2.f * dot(pinhole.d, n) * n)};
    }
    case Rays::Scattered:
      return {4.f * Vec3(rng.uniform(), rng.uniform(), rng.uniform()),
              normalize(sampleUniformSphere(rng.uniform2()))};
  }
  return {};
}

Vec3 anyPerpendicular(const Vec3& d, Rng& rng) {
  const Frame frame = Frame::fromZ(d);
  const float phi = 2 * kPi * rng.uniform();
  return std::cos(phi) * frame.x + std::sin(phi) * frame.y;
}

float ulpsAway(float x, int n) {
  for (; n > 0; --n) x = std::nextafter(x, kInfinity);
  for (; n < 0; ++n) x = std::nextafter(x, -kInfinity);
  return x;
}

/// A photon at an interesting distance along a beam and from it.
Vec3 photonNear(const Beam& beam, Rng& rng) {
  float t = 0;
  switch (rng.below(6)) {
    case 0:
      t = ulpsAway(beam.t0, static_cast<int>(rng.below(9)) - 4);
      break;
    case 1:
      t = ulpsAway(beam.t1, static_cast<int>(rng.below(9)) - 4);
      break;
    case 2:
      t = lerp(beam.t0, beam.t1, 3 * rng.uniform() - 1);
      break;
    default:
      t = lerp(beam.t0, beam.t1, rng.uniform());
  }
  float away = 0;
  switch (rng.below(4)) {
    case 0:
      away = ulpsAway(beam.radius, static_cast<int>(rng.below(9)) - 4);
      break;
    case 1:
      break;
    default:
      away = 1.5f * rng.uniform() * beam.radius;
  }
  return beam.o + t * beam.d + away * anyPerpendicular(beam.d, rng);
}

}  // namespace

std::string toString(Rays rays) {
  switch (rays) {
    case Rays::Pinhole:
      return "Pinhole";
    case Rays::ThinLens:
      return "ThinLens";
    case Rays::Orthographic:
      return "Orthographic";
    case Rays::Environment:
      return "Environment";
    case Rays::Mirrored:
      return "Mirrored";
    case Rays::Scattered:
      return "Scattered";
  }
  return {};
}

std::vector<Beam> makeBeams(const BeamScene& scene, std::uint64_t seed) {
  std::vector<Beam> beams;
  Rng rng(seed);
  const auto pixels = static_cast<std::uint32_t>(scene.resolution.x * scene.resolution.y);
  for (std::uint32_t pixel = 0; pixel < pixels; ++pixel)
    for (int n = 0; n < scene.beamsPerPixel; ++n) {
      if (rng.uniform() >= scene.share) continue;
      const auto width = static_cast<std::uint32_t>(scene.resolution.x);
      const Vec2 raster(static_cast<float>(pixel % width) + rng.uniform(),
                        static_cast<float>(pixel / width) + rng.uniform());
      const Ray ray = rayOf(scene, raster, rng);
      Beam beam{ray.o + scene.shift, scene.t0, ray.d, scene.t1, scene.radius, pixel};
      if (scene.isUneven) {
        beam.t0 = lerp(scene.t0, scene.t1, 0.5f * rng.uniform());
        beam.t1 = lerp(beam.t0, scene.t1, rng.uniform() * 1.2f - 0.1f);  // below t0: empty
        beam.radius *= rng.below(9) == 0 ? 0.f : 3.f * sqr(rng.uniform());
        if (rng.below(20) == 0) beam.t1 = beam.t0;
      }
      beams.push_back(beam);
    }
  for (std::size_t i = beams.size(); i > 1; --i)
    std::swap(beams[i - 1], beams[rng.below(static_cast<std::uint32_t>(i))]);
  return beams;
}

PhotonCloud awkwardPhotons(const std::vector<Beam>& beams, int count, std::uint64_t seed) {
  PhotonCloud photons;
  Rng rng(seed);
  Bounds3 box;
  for (const Beam& beam : beams)
    for (const float t : {beam.t0, beam.t1}) box.extend(beam.o + t * beam.d);
  for (int i = 0; i < count; ++i) {
    const Beam& beam = beams[rng.below(static_cast<std::uint32_t>(beams.size()))];
    const Vec3 u(rng.uniform(), rng.uniform(), rng.uniform());
    switch (rng.below(8)) {
      case 0:
      case 1:
        photons.add(box.lo + 1.2f * (u - 0.1f) * box.diagonal());
        break;
      case 2:
        photons.add(beam.o);
        break;
      case 3:
        photons.add(beam.o - 2.f * beam.radius * u.x * beam.d);
        break;
      case 4:
        photons.add(beam.o + (u.x < 0.5f ? 1e6f : 1e21f) * beam.d);
        break;
      default:
        photons.add(photonNear(beam, rng));
    }
  }
  return photons;
}

}  // namespace brume::test
