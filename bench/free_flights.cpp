// SPDX-License-Identifier: Apache-2.0
// What a free flight costs, against a ray in Embree, and how it grows with a grid.
//
//   brume_free_flights
//
// One thread, processor time, the least of 5 rounds, nanoseconds each:
//   N          voxels along an axis of the cube that the flights cross (chords between random
//   points
//              of its faces)
//   full       random densities everywhere, optical depth about 1 across: depth of a whole chord,
//              and a flight (inversion of the depth, no record)
//   record     the chord's record (MediumAlongRay), which paths use for all they ask
//   1/8        only one eighth of the cube (one octant) has density
//   voxel      time of `depth` over N
#include <fmt/format.h>

#include <ctime>

#include "core/medium_along_ray.h"
#include "core/scene.h"
#include "support/make_plugin.h"
#include "support/volumes.h"

namespace {

using namespace brume;

struct Chord {
  Ray ray;
  Interval range;
};

Vec3 onFace(Rng& rng) {
  Vec3 p(rng.uniform(), rng.uniform(), rng.uniform());
  const std::uint32_t face = rng.below(6);
  p[static_cast<int>(face % 3)] = face < 3 ? 0.f : 1.f;
  return p;
}

std::vector<Ray> chords() {
  std::vector<Ray> rays;
  Rng rng(4);
  while (rays.size() < 1024) {
    const Vec3 a = onFace(rng), b = onFace(rng);
    if (distance(a, b) < 0.3f) continue;
    const Vec3 d = normalize(b - a);
    rays.emplace_back(a - 0.5f * d, d);
  }
  return rays;
}

/// Nanoseconds of f(i), the least of some rounds of `count` calls.
template <class F>
double nanoseconds(int count, F&& f) {
  double least = 1e30, sum = 0;
  for (int round = 0; round < 5; ++round) {
    const std::clock_t start = std::clock();
    for (int i = 0; i < count; ++i) sum += f(i);
    least = std::min(least, double(std::clock() - start) / CLOCKS_PER_SEC * 1e9 / count);
  }
  if (sum == 0.125) fmt::print(" ");  // so that the calls are not left out
  return least;
}

std::unique_ptr<Volume> grid(int n, bool octantOnly) {
  Rng rng(7);
  const auto size = static_cast<std::size_t>(n);
  std::vector<float> density(size * size * size);
  std::size_t i = 0;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x, ++i)
        if (!octantOnly || std::max({x, y, z}) < n / 2) density[i] = 0.5f + rng.uniform();
  test::MediumSpec spec;
  spec.sigma_s = Rgb(1);
  return test::makeGrid(spec, n, n, n, std::move(density));
}

struct Times {
  double depth = 0, flight = 0, record = 0;
};

Times timesOf(const Volume& volume, int count) {
  static const std::vector<Ray> rays = chords();
  std::vector<Chord> crossing;
  for (const Ray& ray : rays)
    if (const auto range = volume.intersect(ray)) crossing.push_back({ray, *range});
  const auto at = [&](int i) -> const Chord& {
    return crossing[static_cast<std::size_t>(i) % crossing.size()];
  };
  Rng rng(1);
  MediumAlongRay record;
  Times t;
  // Chords that miss the occupied part cost what finding that out costs.
  const double share = double(crossing.size()) / double(rays.size());
  t.depth = share * nanoseconds(count, [&](int i) {
              return double{volume.opticalDepth(at(i).ray, at(i).range).r};
            });
  t.flight = share * nanoseconds(count, [&](int i) {
               const auto f =
                   volume.invertOpticalDepth(at(i).ray, at(i).range, 0,
                                             static_cast<float>(-std::log1p(-rng.uniformDouble())));
               return f ? double{*f} : 0.0;
             });
  t.record = share * nanoseconds(count, [&](int i) {
               record.assign(volume, at(i).ray, at(i).range);
               return double{record.opticalDepth().r};
             });
  return t;
}

/// A ray in a soup of triangles in the unit cube, most of which it misses.
double embreeRay(int triangles) {
  Rng rng(5);
  std::vector<Vec3> points;
  std::vector<int> indices;
  const float size = 1.5f / std::cbrt(static_cast<float>(triangles));
  for (int i = 0; i < triangles; ++i) {
    const Vec3 p(rng.uniform(), rng.uniform(), rng.uniform());
    for (int k = 0; k < 3; ++k) {
      points.push_back(p + test::randomDirection(rng) * (0.2f * size));
      indices.push_back(3 * i + k);
    }
  }
  Scene::Contents contents;
  contents.shapes.push_back(test::make<Shape>(
      "trianglemesh", {test::points("P", points), test::integers("indices", indices)}));
  contents.groups[0].primitives.push_back({contents.shapes[0].get(), nullptr, nullptr});
  const Scene scene(std::move(contents));
  const std::vector<Ray> rays = chords();
  return nanoseconds(200'000, [&](int i) {
    const auto hit = scene.accelerator().intersect(rays[static_cast<std::size_t>(i) % rays.size()]);
    return hit ? double{hit->shape.t} : 0.0;
  });
}

}  // namespace

int main() {
  fmt::print("Embree ray, nearest hit: {:.0f} ns in 10,000 triangles, {:.0f} ns in 1,000,000\n\n",
             embreeRay(10'000), embreeRay(1'000'000));
  test::MediumSpec spec;
  spec.sigma_s = Rgb(1);
  const auto line = [](const std::string& name, const Times& t, double n) {
    fmt::print("{:22} {:9.0f} {:9.0f} {:9.0f} {:9.2f}\n", name, t.depth, t.flight, t.record,
               t.depth / n);
  };
  fmt::print("{:22} {:>9} {:>9} {:>9} {:>9}\n", "medium", "depth", "flight", "record", "depth/N");
  line("homogeneous", timesOf(*test::makeHomogeneous(spec), 200'000), 1);
  line("exponential", timesOf(*test::makeExponential(spec, 1, 1), 200'000), 1);
  for (const bool octant : {false, true})
    for (const int n : {16, 32, 64, 128, 256})
      line(fmt::format("grid {}^3{}", n, octant ? ", one octant" : ""),
           timesOf(*grid(n, octant), 640'000 / n), n);
  using namespace test;
  line("cloud, 5 octaves",
       timesOf(*make<Volume>("cloud", {color("sigma_s", Rgb(2)), floats("frequency", {4}),
                                       string("shape", "box")}),
               10'000),
       1);
}
