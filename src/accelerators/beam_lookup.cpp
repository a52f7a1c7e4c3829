// SPDX-License-Identifier: Apache-2.0
#include "accelerators/beam_lookup.h"

#include <numeric>

#include "core/error.h"
#include "core/parallel.h"

namespace brume {
namespace {

/// Beams that one task of the plain scan serves.
constexpr std::int64_t kBeamsAtOnce = 64;

}  // namespace

void checkBeam(const Beam& beam) {
  BRUME_CHECK(isFinite(beam.o) && isFinite(beam.d));
  BRUME_CHECK(std::isfinite(beam.t0) && std::isfinite(beam.t1));
  BRUME_CHECK(std::isfinite(beam.radius) && beam.radius >= 0);
  BRUME_CHECK(std::abs(lengthSquared(beam.d) - 1.f) < 2e-5f);
}

LinearBeams::LinearBeams(std::span<const Beam> beams) : beams_(beams.begin(), beams.end()) {
  for (const Beam& beam : beams_) checkBeam(beam);
  slotBeams_.resize(beams_.size());
  std::iota(slotBeams_.begin(), slotBeams_.end(), 0u);
}

void LinearBeams::findPairs(const PhotonPositions& photons, Sink sink, void* context) const {
  const auto scan = [&](std::size_t index, BeamPairBuffer& found) {
    const Beam& beam = beams_[index];
    const float radius2 = sqr(beam.radius);
    for (std::size_t i = 0; i < photons.size(); ++i) {
      const auto foot = beamFoot(beam.o, beam.d, photons[i]);
      if (isInBeam(foot, {beam.t0, beam.t1}, radius2))
        found.add(static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(i), foot);
    }
  };
  forEachChunk(static_cast<std::int64_t>(beams_.size()), kBeamsAtOnce,
               [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                 BeamPairBuffer found(sink, context);
                 for (std::int64_t i = begin; i < end; ++i)
                   scan(static_cast<std::size_t>(i), found);
                 found.flush();
               });
}

std::size_t LinearBeams::memoryBytes() const {
  return sizeof(*this) + beams_.capacity() * sizeof(Beam) +
         slotBeams_.capacity() * sizeof(std::uint32_t);
}

}  // namespace brume
