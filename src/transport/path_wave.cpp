// SPDX-License-Identifier: Apache-2.0
#include "transport/path_wave.h"

#include "core/lanes_math.h"
#include "core/turns.h"
#include "transport/octahedron.h"

namespace brume {
namespace {

#define BRUME_KERNELS "transport/path_wave.inl"
#include "core/both_lanes.inl"

}  // namespace

void drawNumbers(std::uint64_t dimension, PathWave& wave) {
  hasAvx2() ? avx2::drawNumbers(dimension, wave) : generic::drawNumbers(dimension, wave);
}
void dropEnded(PathWave& wave) { hasAvx2() ? avx2::dropEnded(wave) : generic::dropEnded(wave); }
void findSegmentsNear(const Bounds3& surfaces, PathWave& wave) {
  if (surfaces.isEmpty()) {
    wave.mayMeetSurface.fill(0);
    return;
  }
  hasAvx2() ? avx2::findSegmentsNear(surfaces, wave) : generic::findSegmentsNear(surfaces, wave);
}
void arriveInMedia(PathWave& wave) {
  hasAvx2() ? avx2::arriveInMedia(wave) : generic::arriveInMedia(wave);
}
void rouletteInMedia(float mostSurvive, PathWave& wave) {
  hasAvx2() ? avx2::rouletteInMedia(mostSurvive, wave)
            : generic::rouletteInMedia(mostSurvive, wave);
}
void scatterInMedia(float g, std::uint32_t canStore, PathWave& wave) {
  hasAvx2() ? avx2::scatterInMedia(g, canStore, wave) : generic::scatterInMedia(g, canStore, wave);
}

}  // namespace brume
