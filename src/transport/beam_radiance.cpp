// SPDX-License-Identifier: Apache-2.0
#include "transport/beam_radiance.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>

#include "accelerators/beam_quadtree.h"
#include "core/medium_along_ray.h"
#include "core/parallel.h"
#include "transport/free_flight.h"
#include "transport/kernels.h"
#include "transport/photon_mirror.h"

namespace brume {
namespace {

/// 10 bits of each coordinate, interleaved.
std::uint32_t mortonCode(const Vec3& unit) {
  const auto spread = [](float v) {
    auto x = static_cast<std::uint32_t>(std::clamp(v, 0.f, 1.f) * 1023.f);
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
  };
  return spread(unit.x) | spread(unit.y) << 1 | spread(unit.z) << 2;
}

/// A photon's place along the curve.
struct Place {
  std::uint32_t code, photon;
};

/// By code; equal codes keep their order.
void sortPlaces(std::vector<Place>& places) {
  constexpr int kBits = 30, kDigit = 10;
  constexpr std::uint32_t kMask = (1u << kDigit) - 1;
  std::vector<Place> other(places.size());
  for (int shift = 0; shift < kBits; shift += kDigit) {
    std::array<std::size_t, kMask + 2> begin{};
    for (const Place& place : places) ++begin[(place.code >> shift & kMask) + 1];
    for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
    for (const Place& place : places) other[begin[place.code >> shift & kMask]++] = place;
    places.swap(other);
  }
}

constexpr std::int64_t kAtOnce = 4096;     // photons that one task prepares
constexpr std::size_t kPhotonsAhead = 16;  // are asked of the memory

struct MirrorImage {
  std::uint32_t photon;
  Vec3 p;
  Rgb share;  // of the photon's power
};

/// What one task prepares.
struct Part {
  std::size_t first = 0, count = 0;  // of photons
  std::vector<BeamLobe> lobes;       // what lobesBegin counts in
  bool haveLobes = true;
  std::vector<PhaseLobe> ofOne;  // scratch

  /// False: the photon is not scattered.
  bool append(const Volume& volume, const Photon& photon, BeamPhoton& to) {
    const Rgb scattered = photon.power * albedoOf(volume.at(photon.p));
    if (scattered.isBlack()) return false;
    ofOne.clear();
    haveLobes = volume.appendLobes(photon.p, ofOne);
    to = {photon.p, -photon.wi.unpack(), scattered, 0, 0, 0};
    if (!haveLobes) return true;
    to.g = ofOne[0].g;
    to.power = scattered * ofOne[0].weight;
    to.lobesBegin = static_cast<std::uint32_t>(lobes.size());
    to.lobeCount = static_cast<std::uint32_t>(ofOne.size() - 1);
    for (std::size_t k = 1; k < ofOne.size(); ++k)
      lobes.push_back({scattered * ofOne[k].weight, ofOne[k].g});
    return true;
  }
};

/// The media along the beams that a thread has lately asked for. What it answers does not depend on
/// what it holds.
class MediaOfBeams {
 public:
  const MediumAlongRay& along(std::uint64_t owner, const Volume& volume, const OwnedBeams& beams,
                              std::uint32_t beam) {
    Entry& entry = entries_[beam % kEntries];
    if (entry.owner != owner || entry.beam != beam) {
      const Beam& b = beams.beams[beam];
      entry.owner = owner;
      entry.beam = beam;
      entry.medium.assign(volume, Ray{b.o, b.d, b.t1, beams.owners[beam].time}, {b.t0, b.t1});
    }
    return entry.medium;
  }

 private:
  static constexpr std::size_t kEntries = 4096;
  struct Entry {
    std::uint64_t owner = 0;
    std::uint32_t beam = 0;
    MediumAlongRay medium;
  };
  std::vector<Entry> entries_{kEntries};
};

/// Tells the calls of gatherBeams apart: never 0.
std::atomic<std::uint64_t> lastOwner{0};

}  // namespace

Bounds3 reachOf(std::span<const Beam> beams) {
  Bounds3 bounds;
  for (const Beam& beam : beams) {
    if (beam.isEmpty()) continue;
    const Vec3 a = beam.o + beam.t0 * beam.d, b = beam.o + beam.t1 * beam.d;
    // isInBeam rounds, and so does what stands here.
    const float coordinate = maxComponent(max(abs(beam.o), max(abs(a), abs(b))));
    const Vec3 around(1.001f * beam.radius +
                      4 * kBeamSlack * (coordinate + std::abs(beam.t0) + std::abs(beam.t1)));
    bounds.extend(Bounds3{min(a, b) - around, max(a, b) + around});
  }
  return bounds;
}

VolumePhotons::VolumePhotons(const Volume& volume, std::span<const Photon> photons,
                             const VolumePhotonOptions& options) {
  // Along a space-filling curve, through where photons are: a medium may be far larger.
  Bounds3 bounds;
  for (const Photon& photon : photons)
    if (!photon.isOnSurface()) bounds.extend(photon.p);
  if (bounds.isEmpty()) return;
  const Vec3 scale = Vec3(1) / max(bounds.diagonal(), Vec3(std::numeric_limits<float>::min()));
  const PhotonMirror mirror(volume);
  std::vector<Place> order;
  std::vector<MirrorImage> images;  // counted behind the photons
  order.reserve(photons.size());
  const auto putAt = [&](const Vec3& p, std::size_t index) {
    order.push_back({mortonCode((p - bounds.lo) * scale), static_cast<std::uint32_t>(index)});
  };
  for (std::size_t i = 0; i < photons.size(); ++i) {
    const Photon& photon = photons[i];
    if (photon.isOnSurface()) continue;
    if (options.reach.contains(photon.p))
      putAt(photon.p, i);
    else
      ++outside_;
    if (options.mirrorRadius > 0)
      mirror.forEachImage(photon.p, options.mirrorRadius, [&](const Vec3& p, const Rgb& share) {
        if (!options.reach.contains(p)) return;
        putAt(p, photons.size() + images.size());
        images.push_back({static_cast<std::uint32_t>(i), p, share});
      });
  }
  sortPlaces(order);

  const auto append = [&](Part& part, std::size_t index, BeamPhoton& to) {
    if (index < photons.size()) return part.append(volume, photons[index], to);
    const MirrorImage& image = images[index - photons.size()];
    Photon photon = photons[image.photon];
    photon.power *= image.share;
    if (!part.append(volume, photon, to)) return false;
    to.p = image.p;
    return true;
  };
  // Chunks fill their places in parallel; then black photons, which are rare, leave no gaps.
  photons_.resize(order.size());
  std::vector<Part> parts((order.size() + kAtOnce - 1) / kAtOnce);
  forEachChunk(static_cast<std::int64_t>(order.size()), kAtOnce,
               [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
                 const auto first = static_cast<std::size_t>(begin);
                 Part& part = parts[static_cast<std::size_t>(chunk)];
                 part.first = first;
                 for (std::size_t i = first; i < static_cast<std::size_t>(end); ++i) {
                   // In the order of the curve photons stand anywhere in memory.
                   if (i + kPhotonsAhead < order.size())
                     if (const std::size_t ahead = order[i + kPhotonsAhead].photon;
                         ahead < photons.size())
                       __builtin_prefetch(&photons[ahead]);
                   if (append(part, order[i].photon, photons_[first + part.count])) ++part.count;
                 }
               });
  std::size_t count = 0;
  for (const Part& part : parts) {
    if (count == part.first && lobes_.empty()) {
      count += part.count;  // they stand where they belong
    } else {
      for (std::size_t i = 0; i < part.count; ++i) {
        BeamPhoton photon = photons_[part.first + i];
        photon.lobesBegin += static_cast<std::uint32_t>(lobes_.size());
        photons_[count++] = photon;
      }
    }
    lobes_.insert(lobes_.end(), part.lobes.begin(), part.lobes.end());
    haveLobes_ &= part.haveLobes;
  }
  photons_.resize(count);
}

namespace {

/// albedo(p) alpha, of all lobes.
Rgb scatteredPower(const VolumePhotons& photons, const BeamPhoton& photon) {
  Rgb sum = photon.power;
  for (const BeamLobe& lobe : photons.moreLobes().subspan(photon.lobesBegin, photon.lobeCount))
    sum += lobe.power;
  return sum;
}

}  // namespace

std::vector<BeamSum> gatherBeams(const Volume& volume, const OwnedBeams& beams,
                                 const BeamLookup& lookup, const VolumePhotons& photons) {
  std::vector<BeamSum> sums(beams.beams.size());
  if (const auto* tree = dynamic_cast<const BeamQuadtree*>(&lookup); tree && photons.haveLobes()) {
    if (const auto uniform = volume.uniform()) {
      gatherHomogeneous(*tree, photons.all(), uniform->coefficients.sigma_t(), sums);
      return sums;
    }
    gatherInMedia(
        *tree, photons.all(), photons.moreLobes(),
        [&](std::uint32_t beam, MediumAlongRay& medium) {
          const Beam& b = beams.beams[beam];
          medium.assign(volume, Ray{b.o, b.d, b.t1, beams.owners[beam].time}, {b.t0, b.t1});
        },
        sums);
    return sums;
  }
  const std::uint64_t owner = ++lastOwner;
  lookup.accumulate(
      photons.positions(), std::span(sums),
      [&](BeamSum& sum, std::uint32_t b, std::uint32_t i, const BeamFoot<float>& foot) {
        thread_local MediaOfBeams media;
        const Beam& beam = beams.beams[b];
        const BeamPhoton& photon = photons.all()[i];
        const Rgb Tr = media.along(owner, volume, beams, b).transmittance(foot.t);
        const Rgb phase = volume.phase(photon.p, -beam.d, -photon.w);
        const DiscKernel K2(sqr(beam.radius));
        const Rgb L = Tr * scatteredPower(photons, photon) * phase * K2(foot.d2);
        sum += BeamSum{double{L.r}, double{L.g}, double{L.b}, 1};
      });
  return sums;
}

}  // namespace brume
