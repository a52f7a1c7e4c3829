// SPDX-License-Identifier: Apache-2.0
// Beam lookups: how fast, and how it grows.
//
//   brume_beams report | splat | growth | smoke
//
//   report   512 x 512 beams, 10,000 photons: every lookup against the plain scan, beam by beam
//   splat    512 x 512 beams, radius of 4 pixels: pairs per second beside a naive raster splat
//   growth   beams, photons and radius, one at a time
//   smoke    the three of them with few beams and photons, in seconds: that they work, no figures
//
// Processor time of one thread, the best of several runs: other programs disturb it little.
#include <fmt/format.h>
#include <sys/resource.h>

#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "accelerators/beam_quadtree.h"
#include "core/parallel.h"
#include "core/rng.h"
#include "core/sampling.h"
#include "transport/beam_gather.h"

namespace {

using namespace brume;

constexpr float kNear = 2, kFar = 3;  // the medium along the rays
constexpr float kG = 0.6f;
const Rgb kSigmaT(0.4f, 0.5f, 0.6f);

/// Sides of the image, numbers of photons: of the documented figures, or just enough to run.
struct Sizes {
  int side = 512;
  std::size_t splatPhotons = 200000, reportPhotons = 10000, radiusPhotons = 20000;
  std::vector<int> sides{64, 128, 256, 512, 1024, 2048};
  std::vector<std::size_t> photons{10000, 100000, 1000000, 10000000, 100000000};
};
const Sizes kSmoke{64, 2000, 500, 500, {16, 32}, {1000}};

double processorSeconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// The shortest of up to `runs` runs; stops after about two seconds.
double bestOf(int runs, const std::function<void()>& run) {
  double best = 1e30, sum = 0;
  for (int i = 0; i < runs && (i == 0 || sum + best < 2); ++i) {
    const double begin = processorSeconds();
    run();
    const double seconds = processorSeconds() - begin;
    best = std::min(best, seconds);
    sum += seconds;
  }
  return best;
}

/// A square image; pixel (x, y) looks along (2 x / size - 1, 2 y / size - 1, 1).
struct View {
  int size = 512;
  Vec3 direction(float x, float y) const {
    const float scale = 2.f / static_cast<float>(size);
    return normalize(Vec3(scale * x - 1, scale * y - 1, 1));
  }
  /// So that a photon covers about as many pixels as a disc of this radius.
  float radiusOf(float pixels) const {
    return pixels * 0.5f * (kNear + kFar) * 2.f / static_cast<float>(size) * 0.66f;
  }
};

std::vector<Beam> makeBeams(const View& view, float radius, bool jitter) {
  std::vector<Beam> beams;
  Rng rng(1);
  for (int y = 0; y < view.size; ++y)
    for (int x = 0; x < view.size; ++x) {
      const Vec2 u = jitter ? rng.uniform2() : Vec2(0.5f);
      const Vec3 d = view.direction(static_cast<float>(x) + u.x, static_cast<float>(y) + u.y);
      beams.push_back({Vec3(0), kNear, d, kFar, radius,
                       static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(view.size) +
                           static_cast<std::uint32_t>(x)});
    }
  return beams;
}

/// Uniform over image and depth, in Morton order over the image.
std::vector<BeamPhoton> makePhotons(std::size_t count, bool sorted) {
  std::vector<BeamPhoton> photons(count);
  Rng rng(2);
  for (BeamPhoton& photon : photons) {
    const Vec2 u = rng.uniform2();
    const float t = lerp(kNear, kFar, rng.uniform());
    photon.p = t * normalize(Vec3(2 * u.x - 1, 2 * u.y - 1, 1));
    photon.w = sampleUniformSphere(rng.uniform2());
    photon.power = Rgb(1, 0.8f, 0.6f);
    photon.g = kG;
  }
  if (!sorted) return photons;
  const auto key = [](const BeamPhoton& photon) {
    const auto cell = [](float v) { return static_cast<std::uint32_t>((v + 1.01f) * 1000); };
    return mortonIndex(cell(photon.p.x / photon.p.z), cell(photon.p.y / photon.p.z), 11, 11);
  };
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  for (std::uint32_t i = 0; i < count; ++i) order.emplace_back(key(photons[i]), i);
  std::sort(order.begin(), order.end());
  std::vector<BeamPhoton> result;
  for (const auto& [k, i] : order) result.push_back(photons[i]);
  return result;
}

/// The splat that anyone would write first: for each photon the rectangle of pixels it may touch,
/// row by row; fixed beams through pixel centres, one transmittance per photon.
struct Splat {
  int size;
  float radius;
  std::vector<float> dx, dy, dz, r, g, b;

  Splat(const View& view, float radius_) : size(view.size), radius(radius_) {
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const Vec3 d = view.direction(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
        dx.push_back(d.x);
        dy.push_back(d.y);
        dz.push_back(d.z);
      }
    for (auto* channel : {&dx, &dy, &dz}) channel->resize(channel->size() + 8);
    for (auto* channel : {&r, &g, &b}) channel->assign(dx.size(), 0);
  }

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
  __attribute__((target("avx2,fma"), optimize("O3,fast-math")))
#endif
  void
  add(const BeamPhoton& photon) {
    const Vec3 p = photon.p;
    const float scale = 0.5f * static_cast<float>(size) / p.z;
    const float cx = (p.x + p.z) * scale, cy = (p.y + p.z) * scale;
    const float reach = radius * scale * 1.8f;  // enough at the corners of this view
    const int x0 = std::max(0, static_cast<int>(cx - reach)),
              x1 = std::min(size, static_cast<int>(cx + reach) + 1);
    const int y0 = std::max(0, static_cast<int>(cy - reach)),
              y1 = std::min(size, static_cast<int>(cy + reach) + 1);
    const float p2 = dot(p, p), r2 = radius * radius, invR2 = 1 / r2;
    const float way = std::sqrt(p2) - kNear;
    const float phase = kInv4Pi * (1 - kG * kG) * 3 * kInvPi * invR2;
    const float pr = photon.power.r * phase * std::exp(-kSigmaT.r * way),
                pg = photon.power.g * phase * std::exp(-kSigmaT.g * way),
                pb = photon.power.b * phase * std::exp(-kSigmaT.b * way);
    const float wx = photon.w.x, wy = photon.w.y, wz = photon.w.z;
    const float *ddx = dx.data(), *ddy = dy.data(), *ddz = dz.data();
    float* __restrict rr = r.data(), * __restrict gg = g.data(), * __restrict bb = b.data();
    // Whole vectors: pixels too many cost less than a rest of the loop.
    const int width = (x1 - x0 + 7) / 8 * 8;
    for (int y = y0; y < y1; ++y)
#pragma GCC ivdep
      for (int i = y * size + x0; i < y * size + x0 + width; ++i) {
        const float t = p.x * ddx[i] + p.y * ddy[i] + p.z * ddz[i];
        const float d2 = p2 - t * t;
        const float q = 1 - d2 * invR2;
        const float den = 1 + kG * kG + 2 * kG * (wx * ddx[i] + wy * ddy[i] + wz * ddz[i]);
        const float f = q * q / (den * __builtin_sqrtf(den));
        const float weight = (t >= kNear) & (t <= kFar) & (d2 < r2) ? f : 0.f;
        rr[i] += weight * pr;
        gg[i] += weight * pg;
        bb[i] += weight * pb;
      }
  }
};

std::uint64_t countOf(const std::vector<BeamSum>& sums) {
  std::uint64_t n = 0;
  for (const BeamSum& sum : sums) n += sum.count;
  return n;
}
double totalOf(const std::vector<BeamSum>& sums) {
  double total = 0;
  for (const BeamSum& sum : sums) total += sum.g;
  return total;
}

void printRate(const std::string& name, double seconds, std::size_t photons, std::uint64_t pairs) {
  fmt::print("| {} | {:.2f} | {:.2f} | {:.0f} | {:.2f} |\n", name, 1e3 * seconds,
             1e-6 * static_cast<double>(photons) / seconds,
             1e-6 * static_cast<double>(pairs) / seconds,
             1e9 * seconds / static_cast<double>(pairs));
}

void splat(const Sizes& sizes) {
  const View view{sizes.side};
  const float radius = view.radiusOf(4);
  const std::size_t count = sizes.splatPhotons;
  const auto sorted = makePhotons(count, true), unsorted = makePhotons(count, false);
  fmt::print("| lookup | ms | M photons/s | M pairs/s | ns/pair |\n|---|---|---|---|---|\n");

  std::vector<Beam> beams = makeBeams(view, radius, true);
  double build = 0;
  const BeamQuadtree tree(beams, {view.size, view.size});
  build = bestOf(40, [&] { BeamQuadtree(beams, {view.size, view.size}); });
  std::vector<BeamSum> sums(beams.size());
  const auto gather = [&](const BeamQuadtree& t, const std::vector<BeamPhoton>& photons) {
    std::fill(sums.begin(), sums.end(), BeamSum{});
    gatherHomogeneous(t, photons, kSigmaT, sums);
  };

  for (const auto* photons : {&sorted, &unsorted}) {
    const char* order = photons == &sorted ? "sorted" : "unsorted";
    Splat naive(view, radius);
    // In turn: what else runs on the machine disturbs both alike.
    double s = kInfinity, q = kInfinity;
    for (int round = 0; round < 8; ++round) {
      s = std::min(s, bestOf(5, [&] {
                     for (auto* channel : {&naive.r, &naive.g, &naive.b})
                       std::fill(channel->begin(), channel->end(), 0.f);
                     for (const BeamPhoton& photon : *photons) naive.add(photon);
                   }));
      q = std::min(q, bestOf(5, [&] { gather(tree, *photons); }));
    }
    double total = 0;
    for (const float v : naive.g) total += double{v};
    printRate(fmt::format("naive splat, {}", order), s, count, countOf(sums));
    printRate(fmt::format("quadtree, {}", order), q, count, countOf(sums));
    fmt::print("<!-- sums {:.6g} {:.6g} -->\n", total, totalOf(sums));
  }
  struct Sum {
    float r = 0, g = 0, b = 0;
    Sum& operator+=(const Sum& o) {
      r += o.r;
      g += o.g;
      b += o.b;
      return *this;
    }
  };
  const auto general = [&](const BeamQuadtree& t) {
    std::vector<Sum> perBeam(beams.size());
    t.accumulate(PhotonPositions(std::span(sorted), &BeamPhoton::p), std::span(perBeam),
                 [&](Sum& sum, std::uint32_t b, std::uint32_t i, const BeamFoot<float>& foot) {
                   const BeamPhoton& photon = sorted[i];
                   const Beam& beam = beams[b];
                   const float q = 1 - foot.d2 / sqr(beam.radius);
                   const float den = 1 + kG * kG + 2 * kG * dot(photon.w, beam.d);
                   const float w = q * q / (den * std::sqrt(den));
                   sum.r += w * photon.power.r;
                   sum.g += w * photon.power.g;
                   sum.b += w * photon.power.b;
                 });
  };
  gather(tree, sorted);
  const std::uint64_t pairs = countOf(sums);
  printRate("quadtree, callback", bestOf(40, [&] { general(tree); }), count, pairs);
  const BeamQuadtree space = BeamQuadtree::inSpace(beams);
  printRate("in space", bestOf(40, [&] { gather(space, sorted); }), count, pairs);
  printRate("in space, callback", bestOf(40, [&] { general(space); }), count, pairs);
  fmt::print("build: {:.2f} ms; in space: {:.2f} ms; memory {:.1f} and {:.1f} MB\n", 1e3 * build,
             1e3 * bestOf(40, [&] { BeamQuadtree::inSpace(beams); }),
             1e-6 * static_cast<double>(tree.memoryBytes()),
             1e-6 * static_cast<double>(space.memoryBytes()));
}

/// Photons one coordinate after the other, for scans that the compiler vectorises.
struct PhotonArrays {
  std::vector<float> x, y, z;
  explicit PhotonArrays(const std::vector<BeamPhoton>& photons) {
    for (const BeamPhoton& photon : photons) {
      x.push_back(photon.p.x);
      y.push_back(photon.p.y);
      z.push_back(photon.p.z);
    }
  }
};

/// How many photons a beam contains, by a plain scan in vectors.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
__attribute__((target("avx2"), optimize("O3")))
#endif
std::uint64_t
countInBeam(const Beam& beam, const PhotonArrays& photons) {
  const float *x = photons.x.data(), *y = photons.y.data(), *z = photons.z.data();
  const std::size_t count = photons.x.size();
  const float ox = beam.o.x, oy = beam.o.y, oz = beam.o.z, dx = beam.d.x, dy = beam.d.y,
              dz = beam.d.z, t0 = beam.t0, t1 = beam.t1, radius2 = beam.radius * beam.radius;
  std::uint32_t n = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const float qx = x[i] - ox, qy = y[i] - oy, qz = z[i] - oz;
    const float t = qx * dx + qy * dy + qz * dz;
    const float ex = qx - t * dx, ey = qy - t * dy, ez = qz - t * dz;
    n += (t >= t0) & (t <= t1) & (ex * ex + ey * ey + ez * ez < radius2) ? 1u : 0u;
  }
  return n;
}

/// What the report's program did: every photon against every beam, and what is inside evaluated.
/// Returns the number of pairs.
std::uint64_t scanAndEvaluate(std::span<const Beam> beams, std::span<const BeamPhoton> photons,
                              std::span<BeamSum> sums) {
  std::uint64_t pairs = 0;
  for (std::size_t b = 0; b < beams.size(); ++b) {
    const Beam& beam = beams[b];
    const float radius2 = sqr(beam.radius);
    for (const BeamPhoton& photon : photons) {
      const BeamFoot<float> foot = beamFoot(beam.o, beam.d, photon.p);
      if (!isInBeam(foot, {beam.t0, beam.t1}, radius2)) continue;
      const Rgb Tr = exp(-kSigmaT * (foot.t - beam.t0));
      const float denominator = 1 + kG * kG + 2 * kG * dot(photon.w, beam.d);
      const float phase = kInv4Pi * (1 - kG * kG) / (denominator * std::sqrt(denominator));
      const float K2 = 3 * kInvPi / radius2 * sqr(1 - foot.d2 / radius2);
      const Rgb L = Tr * photon.power * (phase * K2);
      sums[b] += BeamSum{double{L.r}, double{L.g}, double{L.b}, 1};
      ++pairs;
    }
  }
  return pairs;
}

/// The report's experiment: 10,000 photons, 512 x 512 beams. False when the lookups disagree.
bool report(const Sizes& sizes) {
  const View view{sizes.side};
  const float radius = view.radiusOf(4);
  const auto photons = makePhotons(sizes.reportPhotons, false);
  const auto beams = makeBeams(view, radius, true);
  const PhotonPositions positions{std::span(photons), &BeamPhoton::p};
  const auto count = [](void* n, const BeamPairs& pairs) {
    *static_cast<std::uint64_t*>(n) += pairs.slots.size();
  };
  std::uint64_t pairs = 0;
  const LinearBeams linear(beams);
  const double plain = bestOf(1, [&] { linear.findPairs(positions, count, &pairs); });
  const PhotonArrays arrays(photons);
  std::uint64_t vectorPairs = 0;
  const double vectors = bestOf(1, [&] {
    for (const Beam& beam : beams) vectorPairs += countInBeam(beam, arrays);
  });
  const Vec2i resolution(view.size, view.size);
  const BeamQuadtree tree(beams, resolution);
  const double build = bestOf(20, [&] { BeamQuadtree(beams, resolution); });
  std::uint64_t treePairs = 0;
  const double found = bestOf(40, [&] {
    treePairs = 0;
    tree.findPairs(positions, count, &treePairs);
  });
  std::vector<BeamSum> sums(beams.size()), plainSums(beams.size());
  std::uint64_t evaluatedPairs = 0;
  const double evaluated =
      bestOf(1, [&] { evaluatedPairs = scanAndEvaluate(beams, photons, plainSums); });
  const double gathered = bestOf(100, [&] { gatherHomogeneous(tree, photons, kSigmaT, sums); });
  std::fill(sums.begin(), sums.end(), BeamSum{});
  gatherHomogeneous(tree, photons, kSigmaT, sums);

  fmt::print("| lookup | ms | plain scan / this | pairs |\n|---|---|---|---|\n");
  const auto row = [&](const char* name, double of, double seconds, std::uint64_t n) {
    fmt::print("| {} | {:.2f} | {:.0f} | {} |\n", name, 1e3 * seconds, of / seconds, n);
  };
  row("plain scan, beam by beam: pairs", plain, plain, pairs);
  row("the same in vectors of 8", plain, vectors, vectorPairs);
  row("quadtree: pairs", plain, found, treePairs);
  row("plain scan, beam by beam: pairs and their evaluation", evaluated, evaluated, evaluatedPairs);
  row("quadtree: pairs and their evaluation", evaluated, gathered, countOf(sums));
  row("quadtree: evaluation, and the build of the tree", evaluated, gathered + build,
      countOf(sums));
  fmt::print("<!-- sums {:.7g} {:.7g} -->\n", totalOf(plainSums), totalOf(sums));
  return treePairs == pairs && evaluatedPairs == pairs && countOf(sums) == pairs && pairs > 0;
}

/// One row of the growth table. Photons come in batches, as a pass has them.
void growthRow(const char* what, int size, std::size_t count, float pixels) {
  constexpr std::size_t kBatch = 1000000;
  View view;
  view.size = size;
  const auto beams = makeBeams(view, view.radiusOf(pixels), true);
  const Vec2i resolution(size, size);
  double build = 1e30;
  build = bestOf(5, [&] { BeamQuadtree(beams, resolution); });
  const BeamQuadtree tree(beams, resolution);
  const auto photons = makePhotons(std::min(count, kBatch), true);
  std::vector<BeamSum> sums(beams.size());
  double seconds = 0;
  if (count <= kBatch) {
    seconds = bestOf(10, [&] { gatherHomogeneous(tree, photons, kSigmaT, sums); });
    std::fill(sums.begin(), sums.end(), BeamSum{});
    gatherHomogeneous(tree, photons, kSigmaT, sums);
  } else {
    seconds = bestOf(1, [&] {
      for (std::size_t i = 0; i < count; i += kBatch)
        gatherHomogeneous(tree, photons, kSigmaT, sums);
    });
  }
  const double n = static_cast<double>(count), hits = static_cast<double>(countOf(sums)) / n;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  fmt::print("| {} | {}^2 | {:.0e} | {} | {:.1f} | {:.1f} | {:.2f} | {:.1f} | {:.0f} |\n", what,
             size, n, pixels, hits, 1e9 * seconds / n, 1e9 * seconds / (n * hits), 1e3 * build,
             static_cast<double>(usage.ru_maxrss) / 1024);
  std::fflush(stdout);
}

void growth(const Sizes& sizes) {
  fmt::print(
      "| varied | beams | photons | radius, pixels | pairs per photon | ns per photon | ns "
      "per pair | build, ms | peak MB so far |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const int size : sizes.sides) growthRow("beams", size, sizes.splatPhotons, 4);
  for (const std::size_t count : sizes.photons) growthRow("photons", sizes.side, count, 4);
  for (const float pixels : {0.5f, 1.f, 2.f, 4.f, 8.f, 16.f, 32.f})
    growthRow("radius", sizes.side, sizes.radiusPhotons, pixels);
}

}  // namespace

int main(int argc, char** argv) {
  setThreadCount(1);
  const std::string what = argc > 1 ? argv[1] : "";
  const bool isSmoke = what == "smoke";
  const Sizes sizes = isSmoke ? kSmoke : Sizes{};
  bool isKnown = isSmoke, agree = true;
  const auto wanted = [&](const char* name) {
    isKnown |= what == name;
    return isSmoke || what == name;
  };
  if (wanted("splat")) splat(sizes);
  if (wanted("report")) agree = report(sizes);
  if (wanted("growth")) growth(sizes);
  if (!isKnown) fmt::print("brume_beams report | splat | growth | smoke\n");
  if (!agree) fmt::print("the quadtree and the plain scan found different pairs\n");
  return isKnown && agree ? 0 : 1;
}
