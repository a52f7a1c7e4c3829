// SPDX-License-Identifier: Apache-2.0
// Many beams against many photons: for each beam the photons inside it, whatever they carry. This
// page is the contract of all lookups (BeamQuadtree, LinearBeams, ...); what a photon or a beam
// means is up to the caller.
//
//   std::vector<Beam> beams = ...;                        // as the camera rays of a pass made them
//   BeamQuadtree tree(beams, resolution);                 // or BeamQuadtree::inSpace(beams)
//   std::vector<Gathered> sums(beams.size());             // zero
//   tree.accumulate(points, std::span(sums),
//                   [&](Gathered& sum, std::uint32_t beam, std::uint32_t photon,
//                       const BeamFoot<float>& foot) { sum.L += ...; ++sum.count; });
//
// Which pairs. A photon is inside a beam by isInBeam (beam_photon.h): t0 <= t <= t1 for the foot t
// of the photon on the line o + t d, and d2 < radius^2, both computed in float by beamFoot. Every
// lookup calls f for exactly these pairs, each once; foot has the same bits in all of them, and in
// the photon BVH's queries. Bounds only save work: no photon is ever lost to them. A beam with
// t0 > t1 or radius 0 contains nothing. Beams may start anywhere, point anywhere, and several may
// belong to one pixel; each has its own radius.
//
// Order. For each beam f is called in the order of the photons' indices, by one thread at a time.
// The sums are therefore the same bits for any number of threads, and for every lookup that does
// not cut beams into pieces (all but inSpace; there a beam's sum is that of its pieces', added in
// the order along the beam). Neighbouring photons should stand near each other in the arrays: it
// is faster; a space-filling order helps most.
//
// f may run for different beams at once: it must write to `sum` alone. Sum needs a default
// constructor that makes zero and operator+=.
//
// Positions and lengths in one space and unit of the caller's choice (brume: render space).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accelerators/beam_photon.h"
#include "core/math.h"

namespace brume {

/// A stretch of a line with a radius: the points whose foot o + t d has t0 <= t <= t1, at a
/// distance below the radius. Lookups check it: all finite, |d| = 1 to 1e-5, radius >= 0.
struct Beam {
  Vec3 o{0};
  float t0 = 0;
  Vec3 d{0, 0, 1};
  float t1 = 0;
  float radius = 0;
  std::uint32_t pixel = 0;  ///< y * width + x; orders the image tree, means nothing else

  bool isEmpty() const { return !(t0 <= t1) || !(radius > 0); }
};

/// Photons, as far as a lookup knows them: three arrays of coordinates, or a Vec3 at equal
/// distances inside of larger records.
class PhotonPositions {
 public:
  PhotonPositions(std::span<const float> x, std::span<const float> y, std::span<const float> z)
      : x_(x.data()), y_(y.data()), z_(z.data()), size_(x.size()) {}
  /// The position is a member of each record: PhotonPositions(records, &Record::p).
  template <class Record>
  PhotonPositions(std::span<const Record> records, Vec3 Record::*position)
      : size_(records.size()), apart_(sizeof(Record) / sizeof(float)) {
    static_assert(sizeof(Record) % sizeof(float) == 0);
    if (records.empty()) return;
    const Vec3& first = records[0].*position;
    x_ = &first.x;
    y_ = &first.y;
    z_ = &first.z;
  }

  std::size_t size() const { return size_; }
  Vec3 operator[](std::size_t i) const { return {x_[i * apart_], y_[i * apart_], z_[i * apart_]}; }

 private:
  const float *x_ = nullptr, *y_ = nullptr, *z_ = nullptr;
  std::size_t size_ = 0, apart_ = 1;
};

/// Pairs that were found, in structure-of-arrays form. A slot stands for a beam or a piece of one.
struct BeamPairs {
  std::span<const std::uint32_t> slots, photons;
  std::span<const float> t, d2;  ///< see BeamFoot
};

/// See the head of this file. Immutable; the beams are copied.
class BeamLookup {
 public:
  virtual ~BeamLookup() = default;

  /// Calls f(sums[beam], beam, photon, foot) for each pair.
  template <class Sum, class F>
  void accumulate(const PhotonPositions& photons, std::span<Sum> sums, F&& f) const {
    if (!hasPieces_) return gather(photons, sums, f, slotBeams_.data());
    std::vector<Sum> slotSums(slotBeams_.size());
    gather(photons, std::span<Sum>(slotSums), f, nullptr);
    for (std::size_t slot = 0; slot < slotBeams_.size(); ++slot)
      if (slotBeams_[slot] != kNoBeam) sums[slotBeams_[slot]] += slotSums[slot];
  }

  /// Receives pairs, one beam's in order and by one thread at a time.
  using Sink = void (*)(void* context, const BeamPairs& pairs);
  virtual void findPairs(const PhotonPositions& photons, Sink sink, void* context) const = 0;

  static constexpr std::uint32_t kNoBeam = 0xffffffffu;
  /// The beam of each slot; kNoBeam for slots that are never found. The slots of a beam's pieces
  /// follow in their order along it.
  std::span<const std::uint32_t> slotBeams() const { return slotBeams_; }
  /// Whether a beam may have several slots.
  bool hasPieces() const { return hasPieces_; }
  /// Of this object and what it owns.
  virtual std::size_t memoryBytes() const = 0;

 protected:
  std::vector<std::uint32_t> slotBeams_;
  bool hasPieces_ = false;

 private:
  template <class Sum, class F>
  void gather(const PhotonPositions& photons, std::span<Sum> sums, F&& f,
              const std::uint32_t* sumOfSlot) const {
    struct Context {
      std::span<Sum> sums;
      F& f;
      const std::uint32_t *sumOfSlot, *slotBeams;
    } context{sums, f, sumOfSlot, slotBeams_.data()};
    findPairs(
        photons,
        [](void* p, const BeamPairs& pairs) {
          auto& [to, call, sumAt, beamAt] = *static_cast<Context*>(p);
          for (std::size_t i = 0; i < pairs.slots.size(); ++i) {
            const std::uint32_t slot = pairs.slots[i];
            call(to[sumAt ? sumAt[slot] : slot], beamAt[slot], pairs.photons[i],
                 BeamFoot<float>{pairs.t[i], pairs.d2[i]});
          }
        },
        &context);
  }
};

/// Throws InternalError unless the beam is as Beam promises.
void checkBeam(const Beam& beam);

/// Every photon against every beam: what the other lookups are tested against and compared with.
class LinearBeams final : public BeamLookup {
 public:
  explicit LinearBeams(std::span<const Beam> beams);
  void findPairs(const PhotonPositions& photons, Sink sink, void* context) const override;
  std::size_t memoryBytes() const override;

 private:
  std::vector<Beam> beams_;
};

/// Pairs on their way to a sink, so that it is called for many at once.
class BeamPairBuffer {
 public:
  static constexpr std::size_t kCapacity = 512;

  BeamPairBuffer(BeamLookup::Sink sink, void* context) : sink_(sink), context_(context) {}

  /// Where the next pairs go; vectors may be written there whole.
  struct Room {
    std::uint32_t *slots, *photons;
    float *t, *d2;
  };
  Room room(std::size_t count) {
    if (size_ + count > kCapacity) flush();
    return {slots_ + size_, photons_ + size_, t_ + size_, d2_ + size_};
  }
  /// The first n that were written to room() are pairs.
  void keep(std::size_t n) { size_ += n; }

  void add(std::uint32_t slot, std::uint32_t photon, const BeamFoot<float>& foot) {
    const Room to = room(1);
    *to.slots = slot;
    *to.photons = photon;
    *to.t = foot.t;
    *to.d2 = foot.d2;
    keep(1);
  }
  void flush() {
    if (size_ > 0) sink_(context_, {{slots_, size_}, {photons_, size_}, {t_, size_}, {d2_, size_}});
    size_ = 0;
  }

 private:
  BeamLookup::Sink sink_;
  void* context_;
  std::size_t size_ = 0;
  std::uint32_t slots_[kCapacity], photons_[kCapacity];
  float t_[kCapacity], d2_[kCapacity];
};

}  // namespace brume
