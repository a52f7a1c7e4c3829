// SPDX-License-Identifier: Apache-2.0
#include "transport/beam_radiance.h"

#include <algorithm>
#include <atomic>
#include <limits>

#include "accelerators/beam_quadtree.h"
#include "core/counting_sort.h"
#include "core/medium_along_ray.h"
#include "core/parallel.h"
#include "core/reuse.h"
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

constexpr std::int64_t kAtOnce = 4096;     // photons that one task prepares
constexpr std::size_t kPhotonsAhead = 16;  // are asked of the memory

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

/// What one task makes of the photons in their order.
struct VolumePhotons::Part {
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

/// The photons that one task finds places for.
struct VolumePhotons::Placed {
  std::vector<Place> places;        // images count from the number of photons on
  std::vector<MirrorImage> images;  // of this task
  std::uint32_t firstImage = 0;     // among those of all tasks
  std::size_t outside = 0;
};

namespace {

std::size_t chunksOf(std::size_t count) {
  return (count + std::size_t{kAtOnce} - 1) / std::size_t{kAtOnce};
}

/// Of the photons in media.
Bounds3 boundsOf(std::span<const Photon> photons) {
  std::vector<Bounds3> parts(chunksOf(photons.size()));
  forEachChunk(static_cast<std::int64_t>(photons.size()), kAtOnce,
               [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
                 Bounds3 bounds;
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end);
                      ++i)
                   if (!photons[i].isOnSurface()) bounds.extend(photons[i].p);
                 parts[static_cast<std::size_t>(chunk)] = bounds;
               });
  Bounds3 all;
  for (const Bounds3& part : parts) all.extend(part);
  return all;
}

}  // namespace

void VolumePhotons::assign(const Volume& volume, std::span<const Photon> photons,
                           const VolumePhotonOptions& options) {
  std::vector<Placed> parts = placesOf(volume, photons, options);
  outside_ = 0;
  std::uint32_t images = 0;
  for (Placed& part : parts) {
    outside_ += part.outside;
    part.firstImage = images;
    images += static_cast<std::uint32_t>(part.images.size());
  }
  resizeForReuse(images_, images);
  for (const Placed& part : parts)
    std::copy(part.images.begin(), part.images.end(), images_.begin() + part.firstImage);
  sort(parts, photons.size());
  fill(volume, photons);
}

/// Along a space-filling curve, through where photons are: a medium may be far larger.
std::vector<VolumePhotons::Placed> VolumePhotons::placesOf(
    const Volume& volume, std::span<const Photon> photons,
    const VolumePhotonOptions& options) const {
  const Bounds3 bounds = boundsOf(photons);
  if (bounds.isEmpty()) return {};
  const Vec3 scale = Vec3(1) / max(bounds.diagonal(), Vec3(std::numeric_limits<float>::min()));
  const PhotonMirror mirror(volume);
  std::vector<Placed> parts(chunksOf(photons.size()));
  forEachChunk(static_cast<std::int64_t>(photons.size()), kAtOnce,
               [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
                 Placed& part = parts[static_cast<std::size_t>(chunk)];
                 part.places.reserve(static_cast<std::size_t>(end - begin));
                 const auto putAt = [&](const Vec3& p, std::size_t index) {
                   part.places.push_back(
                       {mortonCode((p - bounds.lo) * scale), static_cast<std::uint32_t>(index)});
                 };
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end);
                      ++i) {
                   const Photon& photon = photons[i];
                   if (photon.isOnSurface()) continue;
                   if (options.reach.contains(photon.p))
                     putAt(photon.p, i);
                   else
                     ++part.outside;
                   if (options.mirrorRadius > 0)
                     mirror.forEachImage(
                         photon.p, options.mirrorRadius, [&](const Vec3& p, const Rgb& share) {
                           if (!options.reach.contains(p)) return;
                           putAt(p, photons.size() + part.images.size());
                           part.images.push_back({static_cast<std::uint32_t>(i), p, share});
                         });
                 }
               });
  return parts;
}

/// By code; equal codes keep their order.
void VolumePhotons::sort(std::span<const Placed> parts, std::size_t photonCount) {
  constexpr int kBits = 30, kDigit = 10;
  constexpr std::size_t kBuckets = std::size_t{1} << kDigit;
  std::size_t count = 0;
  for (const Placed& part : parts) count += part.places.size();
  resizeForReuse(order_, count);
  resizeForReuse(other_, count);

  const auto digit = [](int shift) {
    return [shift](const Place& place) { return place.code >> shift & (kBuckets - 1); };
  };
  const std::size_t ofParts = sortGroups(count, kBuckets, parts.size());
  countingSort(
      ofParts, kBuckets,
      [&](std::size_t group, const auto& f) {
        const auto [first, end] = groupRange(group, ofParts, parts.size());
        for (std::size_t i = first; i < end; ++i)
          for (Place place : parts[i].places) {
            if (place.photon >= photonCount) place.photon += parts[i].firstImage;
            f(place);
          }
      },
      digit(0), [&](const Place& place, std::uint32_t at) { order_[at] = place; });
  const std::size_t groups = sortGroups(count, kBuckets, count);
  for (int shift = kDigit; shift < kBits; shift += kDigit) {
    countingSort(
        groups, kBuckets,
        [&](std::size_t group, const auto& f) {
          const auto [first, end] = groupRange(group, groups, count);
          for (std::size_t i = first; i < end; ++i) f(order_[i]);
        },
        digit(shift), [&](const Place& place, std::uint32_t at) { other_[at] = place; });
    order_.swap(other_);
  }
}

/// The photons in their order.
void VolumePhotons::fill(const Volume& volume, std::span<const Photon> photons) {
  const auto append = [&](Part& part, std::size_t index, BeamPhoton& to) {
    if (index < photons.size()) return part.append(volume, photons[index], to);
    const MirrorImage& image = images_[index - photons.size()];
    Photon photon = photons[image.photon];
    photon.power *= image.share;
    if (!part.append(volume, photon, to)) return false;
    to.p = image.p;
    return true;
  };
  // Chunks fill their places in parallel; then black photons, which are rare, leave no gaps.
  resizeForReuse(photons_, order_.size());
  std::vector<Part> parts(chunksOf(order_.size()));
  forEachChunk(static_cast<std::int64_t>(order_.size()), kAtOnce,
               [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
                 const auto first = static_cast<std::size_t>(begin);
                 Part& part = parts[static_cast<std::size_t>(chunk)];
                 part.first = first;
                 for (std::size_t i = first; i < static_cast<std::size_t>(end); ++i) {
                   // In the order of the curve photons stand anywhere in memory.
                   if (i + kPhotonsAhead < order_.size())
                     if (const std::size_t ahead = order_[i + kPhotonsAhead].photon;
                         ahead < photons.size())
                       __builtin_prefetch(&photons[ahead]);
                   if (append(part, order_[i].photon, photons_[first + part.count])) ++part.count;
                 }
               });
  std::size_t count = 0;
  lobes_.clear();
  haveLobes_ = true;
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
                                 const BeamLookup& lookup, const VolumePhotons& photons,
                                 std::vector<BeamSum> old) {
  std::vector<BeamSum> sums = std::move(old);
  resizeForReuse(sums, beams.beams.size());
  std::fill(sums.begin(), sums.end(), BeamSum{});
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
